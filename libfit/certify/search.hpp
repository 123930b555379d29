#pragma once

#include "libfit/certify/slip_balance.hpp"
#include "libfit/certify/witness.hpp"

namespace palpate::certify {

enum class Verdict {
  certified,  ///< every slip dissipates
  fails,      ///< a witness creates energy
  undecided   ///< the bound did not close
};
enum class Cause { none, normals, stiffness, curvature, rings, concave, friction, sway };
constexpr const char* kCauseNames[] = {"none",  "normals", "stiffness", "curvature",
                                       "rings", "concave", "friction",  "sway"};

/// Sliding on a triangle, for one state of the other rings.
struct Sliding {
  Verdict verdict = Verdict::undecided;
  double ratio = 0;  ///< bound: the share of its friction that it needs; infinite: none is enough
  double worst_found = 0;  ///< largest ratio at a place
  double friction = 0;     ///< mu there
  Cause cause = Cause::none;
  Witness witness;  ///< where it fails
};

/// Whether (M22) holds on a triangle of an asset of rings with a covered corner, at every depth.
bool pushes_on(const runtime::AssetView& asset, int t, const FacetOptions& options);

/// Certifies sliding on a triangle of an asset of rings, with all corners covered: by branch and
/// bound over its places and depths, with the direction by sectors (M21). Deterministic.
Sliding certify_sliding(const runtime::AssetView& asset, int t, OtherRings others,
                        const FacetOptions& options);

}  // namespace palpate::certify
