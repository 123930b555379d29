#pragma once

#include "libfit/certify/slip_balance.hpp"

namespace palpate::certify {

/// A contact that is about to slip: its point on a triangle, and how its rings are deflected.
struct SlipState {
  PatchPoint place;
  double depth_m = 0;
  runtime::Vec3d ring[kRings];  ///< q_i, tangential, in the asset's axes
};

/// The engine's contact in that state, and where its tip or ball is [m], in body coordinates. On a
/// body that sways the state is what the law sees, and the tool stands where the sway brings it. Of
/// a body that relaxes: one whose view has no branches, as in slow motion.
struct StagedContact {
  runtime::Contact contact;
  double tip_m[3];
};
StagedContact stage(const runtime::AssetView& asset, int t, double radius_m,
                    const SlipState& state);

/// A slip that creates energy, as the engine replays it.
struct Witness {
  int triangle = -1;
  double weight[3] = {0, 0, 0};  ///< area coordinates of the contact point
  double depth_m = 0, deflection_m = 0;
  double direction[3] = {0, 0, 0};  ///< of the deflection, a unit vector
  double created_J =
      0;  ///< what the engine's energy rises by with the tool held; <= 0: it dissipates
  double stored_J = 0;  ///< before
};

/// Replays a slip through the engine without its guard, on a body that relaxes in slow motion: ring
/// 1 at its limit along a direction of Balance, the others as they store most.
Witness replay_slip(const runtime::AssetView& asset, const Facet& facet, int t,
                    const PatchPoint& place, double depth_m, int sector, OtherRings others);

}  // namespace palpate::certify
