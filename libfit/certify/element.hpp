#pragma once

#include "libfit/certify/slip_balance.hpp"

namespace palpate::certify {

/// What is asked of an element.
struct ElementOptions {
  double radius_m = 0;       ///< of the ball that slides; 0: a tip
  double max_step_m = 5e-5;  ///< of a tick: 50 mm/s at 1 kHz
  int max_boxes = 400;       ///< patches times ranges of depth, before a bound is left as it is
};

enum class Verdict {
  certified,  ///< every slip dissipates
  fails,      ///< a witness creates energy
  undecided   ///< the bound did not close
};
enum class Cause { none, normals, stiffness, curvature, rings, concave, friction };
constexpr const char* kCauseNames[] = {"none",  "normals", "stiffness", "curvature",
                                       "rings", "concave", "friction"};

/// A slip that creates energy, as the engine replays it.
struct Witness {
  int triangle = -1;
  double weight[3] = {0, 0, 0};  ///< area coordinates of the contact point
  double depth_m = 0, deflection_m = 0;
  double direction[3] = {0, 0, 0};  ///< of the deflection, a unit vector
  double created_J = 0;  ///< measured: what the engine's energy rises by with the tool held
  double stored_J = 0;   ///< before
};

/// Sliding on an element, for one state of the other rings.
struct Sliding {
  Verdict verdict = Verdict::undecided;
  double ratio = 0;  ///< bound: the share of its friction that it needs; infinite: none is enough
  double worst_found = 0;  ///< largest ratio at a place
  double friction = 0;     ///< mu there
  Cause cause = Cause::none;
  Witness witness;
};

struct ElementCertificate {
  Sliding any, sliding;  ///< by OtherRings
  double max_depth_m = 0;
};

/// Triangle t, with all corners covered, of a body of rings.
Element element_of(const runtime::AssetView& asset, int t, const ElementOptions& options);
/// What its curves say at a depth, or over a range of depths within one piece of the basis.
Depth<double> at_depth(const runtime::AssetView& asset, const Element& element, int t, double d);
Depth<Interval> over_depths(const runtime::AssetView& asset, const Element& element, int t,
                            double from_m, double to_m);

/// Whether (M22) holds on a triangle of an asset of rings with a covered corner, at every depth.
bool pushes_on(const runtime::AssetView& asset, int t, const ElementOptions& options);

/// Certifies sliding on a triangle of an asset of rings: by branch and bound over its places and
/// depths, with the direction by sectors (M21). Its range of depths ends with the curves and with
/// its max_depth_m. Deterministic.
ElementCertificate certify_element(const runtime::AssetView& asset, int t,
                                   const ElementOptions& options);

/// Replays a slip through the engine without its guard: the contact point at a place of triangle
/// t, ring 1 at its limit along `toward` (a direction of the facet as in Balance), the others as
/// they store most. created_J > 0: the slip creates energy.
Witness replay_slip(const runtime::AssetView& asset, const Element& element, int t,
                    const Place& place, double depth_m, int sector, OtherRings others);

}  // namespace palpate::certify
