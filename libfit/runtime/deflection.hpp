// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Where a tool stands against its contact point: depth and lateral deflection in the frame of the
// spot, from where the body leans to, as long as the body's metric says (docs/method.md, sections 1
// and 2). One template for the engine (scalar double) and the fitter (scalar double or ceres::Jet).
// A Spot is a place where a contact point can stand: .point [m], .normal (inward unit),
// .control(curve, j) [N], .lean(j) [m], .anisotropy(i) [1].

#include "scalar.hpp"
#include "spline.hpp"

namespace palpate {
namespace runtime {

constexpr int kNormal = 0, kLateral = 1, kLimit = 2;  ///< f^z(dz), f^r(dr), L(dz)
constexpr int kCurves = 3;
constexpr int kLean = 3;        ///< where the lean l(dz) stands after them
constexpr int kAnisotropy = 4;  ///< where the anisotropy S stands after that

/// S is a symmetric tensor: xx, yy, zz, xy, xz, yz.
constexpr int kTensorSize = 6;
/// Largest Frobenius norm of S. A blend of such tensors is one, and I + S keeps every direction's
/// stiffness between a tenth and 1.9 times the mean.
constexpr double kMaxAnisotropy = 0.9;

constexpr double kLateralZero_m = 1e-12;  ///< below a picometre the lateral direction is noise

/// The bases of the three curves and of the lean, shared by the body.
struct CurveViews {
  SplineView view[kCurves];
  SplineView lean;              ///< of l(dz); no pieces: the body does not lean
  double coupling_depth_m = 0;  ///< the depth at which G is 1; 0: G is 1 everywhere
  bool is_anisotropic = false;  ///< f^r reads the length of dr by I + S
};

// e bounds the slope at 500 / D. A tool that lifts off while it slides keeps a lateral deflection
// dr = 2 L' D sqrt(e) / f^r', and with it a normal force of L' dr / 2, 0.5 mN at L' = 120 N/m,
// f^r' = 300 N/m and D = 10 mm: a hundred times the e leaves ten times the pop.
constexpr double kGainOffset = 1e-6, kGainRoot = 1e-3;  ///< e and its root, see gain_at
constexpr double kGainSpan = 0.999000499999875;         ///< sqrt(1 + e) - sqrt(e)

/// G = (sqrt(dz/D + e) - sqrt(e)) / (sqrt(1 + e) - sqrt(e)) and dG/d(dz) at dz > 0: the root of the
/// depth, as a ball's contact radius grows, with a slope at zero (docs/method.md, M3c).
template <class T>
struct Gain {
  T value, slope;
};
template <class T>
Gain<T> gain_at(double coupling_depth_m, const T& depth_m) noexcept {
  using std::sqrt;
  const T root = sqrt(depth_m * (1.0 / coupling_depth_m) + kGainOffset);
  return {(root - kGainRoot) * (1.0 / kGainSpan), (0.5 / (kGainSpan * coupling_depth_m)) / root};
}

/// A tool's deflection in the frame of its contact point.
template <class T>
struct Deflection {
  T normal_m;       ///< dz, > 0 in contact
  T lateral_m;      ///< dr >= 0, from where the body leans to; exactly 0 below kLateralZero_m
  Vec3<T> lateral;  ///< u^r; zero vector where dr is 0
  T lean_rate;      ///< pull . dl/d(dz) [1]: what the lateral force takes from the normal one
  Gain<T> gain;     ///< G(dz) [1] of a coupled body, 0 where dz <= 0; else not read
  /// Of an anisotropic body, else not read: rho = stretch dr is where f^r is read, f^r pull the
  /// lateral force, pull_size the length of pull [1].
  T stretch, pull_size;
  Vec3<T> pull;
};

/// rho, the length of the lateral deflection by the body's metric [m]: where f^r and R are read.
template <class T>
T metric_length_m(const CurveViews& views, const Deflection<T>& d) noexcept {
  return views.is_anisotropic ? d.stretch * d.lateral_m : d.lateral_m;
}
/// Size of the lateral force [N] where G f^r(rho) is lateral_N.
template <class T>
T lateral_size(const CurveViews& views, const Deflection<T>& d, const T& lateral_N) noexcept {
  return views.is_anisotropic ? d.pull_size * lateral_N : lateral_N;
}

/// l and dl/d(dz) of a spot.
template <class T>
struct Lean {
  Vec3<T> value_m, slope;
};
template <class T, class Spot>
Lean<T> lean_at(const SplineView& view, const Spot& spot, const T& depth_m) noexcept {
  const SplineWeights<T> w = spline_weights(view, find_piece(view, value_of(depth_m)), depth_m);
  const Vec3<T> nothing{T(0), T(0), T(0)};
  Lean<T> out{nothing, nothing};
  for (int k = 0; k <= view.degree; ++k) {
    const Vec3<T> control = spot.lean(w.first + k);
    out.value_m = out.value_m + control * w.value[k];
    out.slope = out.slope + control * w.slope[k];
  }
  return out;
}

/// The symmetric tensor S of a spot times v.
template <class T, class Spot>
Vec3<T> anisotropy_times(const Spot& spot, const Vec3<T>& v) noexcept {
  const T xy = spot.anisotropy(3), xz = spot.anisotropy(4), yz = spot.anisotropy(5);
  return {spot.anisotropy(0) * v.x + xy * v.y + xz * v.z,
          xy * v.x + spot.anisotropy(1) * v.y + yz * v.z,
          xz * v.x + yz * v.y + spot.anisotropy(2) * v.z};
}

/// Length of the lateral direction by M = I + S and its gradient (docs/method.md, M3d): stretch =
/// sqrt(u^r.M u^r), pull = P M u^r / stretch, P = I - u u^T.
template <class T, class Spot>
void fill_metric(const Spot& spot, Deflection<T>& d) noexcept {
  using std::sqrt;
  const Vec3<T> bent = d.lateral + anisotropy_times<T>(spot, d.lateral);
  d.stretch = sqrt(dot(bent, d.lateral));
  d.pull = (bent - spot.normal * dot(bent, spot.normal)) * (1.0 / d.stretch);
  d.pull_size = sqrt(dot(d.pull, d.pull));
}

/// The deflection of a tool at x [m] whose contact point is the spot.
template <class T, class Spot>
Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  using std::sqrt;
  const Vec3<T> delta = x - spot.point;
  const Vec3<T> nothing{T(0), T(0), T(0)};
  Deflection<T> out{
      dot(delta, spot.normal), T(0), nothing, T(0), {T(0), T(0)}, T(1), T(1), nothing};
  if (views.coupling_depth_m > 0 && value_of(out.normal_m) > 0)
    out.gain = gain_at(views.coupling_depth_m, out.normal_m);
  Vec3<T> lateral = delta - spot.normal * out.normal_m;
  const bool leans = views.lean.pieces > 0 && value_of(out.normal_m) > 0;
  Vec3<T> slope = nothing;
  if (leans) {  // (M3a) in place of (M2)
    const Lean<T> lean = lean_at(views.lean, spot, out.normal_m);
    lateral = lateral - (lean.value_m - spot.normal * dot(lean.value_m, spot.normal));
    slope = lean.slope;
  }
  const T squared = dot(lateral, lateral);
  if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
  out.lateral_m = sqrt(squared);
  out.lateral = lateral * (1.0 / out.lateral_m);
  if (views.is_anisotropic) fill_metric(spot, out);
  if (leans) out.lean_rate = dot(slope, views.is_anisotropic ? out.pull : out.lateral);
  return out;
}

}  // namespace runtime
}  // namespace palpate
