#pragma once

// A triangle of a body of rings, as a certificate reads it.

#include "libfit/certify/interval.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::certify {

constexpr int kRings = runtime::kRings;

/// What is asked of a triangle.
struct FacetOptions {
  double radius_m = 0;       ///< of the ball that slides; 0: a tip
  double max_step_m = 5e-5;  ///< of a tick: 50 mm/s at 1 kHz
  double depth_share = 1;    ///< of the triangle's range of depths
  int max_boxes = 1000;      ///< patches times ranges of depth, before a bound is left as it is
  double of_failing = 0.25;  ///< share of the boxes where a place has failed
  double far = 0.5;          ///< a bound below it need not be tight
};

/// A triangle of a body of rings in a frame of its own: x and y in the facet, z along its inward
/// normal. Vectors are [component][corner], gradients [component][x, y].
struct Facet {
  double gradient[3][2];            ///< of the area coordinates [1/m]
  double normal[3][3], turn[3][2];  ///< u_l, and the gradient of their blend
  double lambda[3], friction[3], friction_slope[3], outward[3], stiffness[kRings][3];
  double outward_turn[2];  ///< of gamma [1/m^2]
  double side2[3][3], side3[3][3], side2_turn[3][2], side3_turn[3][2];
  double curvature[6][3], curvature_turn[2][6];  ///< xx, yy, zz, xy, xz, yz
  double sway[6][3], sway_turn[2][6];            ///< C [m/N] of a body that sways, likewise
  bool sways = false;
  double threshold[kRings];
  double radius_m = 0;     ///< of the ball that slides; 0: a tip
  double overshoot_m = 0;  ///< how far beyond its limit ring 1 may be at a tick
  runtime::Vec3d axis[3];  ///< of the frame, in the asset's
};

/// A place of a triangle, and a patch: the triangle between three places.
struct PatchPoint {
  double n[3];
  template <class T>
  T blend(const T* v) const {
    return v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
  }
};
struct Patch {
  PatchPoint corner[3];
  template <class T>
  Interval blend(const T* v) const {
    return hull(hull(Interval(corner[0].blend(v)), Interval(corner[1].blend(v))),
                Interval(corner[2].blend(v)));
  }
};

/// What the normal curves of the corners say at a depth or over a range of depths, over that depth.
template <class T>
struct CurveTerms {
  T m;                ///< d
  T force[3];         ///< f^z / d [N/m]
  T force_slope[2];   ///< of the blended f^z over the facet, / d [N/m^2]
  T energy_slope[2];  ///< of the blended Z over the facet, / d [N/m]
  T energy[3];        ///< Z / d^2 [N/m]
  T bed[3];           ///< sum of c_i h_i / d [N/m], of all rings
  /// f^z and the sum of c_i h_i at the middle of the range [N], and their slopes over it [N/m]; of
  /// a depth, nothing.
  double half_m = 0, force_there[3] = {}, bed_there[3] = {};
  T force_rise[3], bed_rise[3];
};

/// Triangle t, with a covered corner, of a body of rings.
Facet facet_of(const runtime::AssetView& asset, int t, const FacetOptions& options);

/// Up to which depth it is certified: the end of the curves, or where slides are ill-conditioned.
double range_of(const runtime::AssetView& asset, int t);

/// What its curves say at a depth, or over a range of depths within one piece of the basis.
CurveTerms<double> at_depth(const runtime::AssetView& asset, const Facet& facet, int t, double d);
CurveTerms<Interval> over_depths(const runtime::AssetView& asset, const Facet& facet, int t,
                                 double from_m, double to_m);

}  // namespace palpate::certify
