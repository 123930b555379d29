// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a contact point answers to a deflection: the forces of its curves and what they store
// (docs/method.md, section 2), one template for the engine (scalar double) and the fitter (scalar
// double or ceres::Jet). A Spot is a place where a contact point can stand: .point [m], .normal
// (inward unit), .control(curve, j) [N], .lean(j) [m], .anisotropy(i) [1]. Forces are those of the
// tool ON the body.

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

/// Where f^r and R of a deflection are read [m].
template <class T>
T read_at_m(const CurveViews& views, const Deflection<T>& d) noexcept {
  return views.is_anisotropic ? d.stretch * d.lateral_m : d.lateral_m;
}
/// Size of the lateral force [N] whose curve says lateral_N.
template <class T>
T traction(const CurveViews& views, const Deflection<T>& d, const T& lateral_N) noexcept {
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
void stretch(const Spot& spot, Deflection<T>& d) noexcept {
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
  if (leans) {
    const Lean<T> lean = lean_at(views.lean, spot, out.normal_m);
    lateral = lateral - (lean.value_m - spot.normal * dot(lean.value_m, spot.normal));
    slope = lean.slope;
  }
  const T squared = dot(lateral, lateral);
  if (!(value_of(squared) > kLateralZero_m * kLateralZero_m)) return out;
  out.lateral_m = sqrt(squared);
  out.lateral = lateral * (1.0 / out.lateral_m);
  if (views.is_anisotropic) stretch(spot, out);
  if (leans) out.lean_rate = dot(slope, views.is_anisotropic ? out.pull : out.lateral);
  return out;
}

/// The control values alive on one interval.
template <int kOrder, class T>
struct LiveControls {
  T b[kOrder];
};
/// Those of a spot from `first` on. A spot that has them at hand brings an overload.
template <int kOrder, class Spot>
auto live_controls(const Spot& spot, int curve, int first) noexcept
    -> LiveControls<kOrder, decltype(spot.control(curve, first))> {
  LiveControls<kOrder, decltype(spot.control(curve, first))> out;
  for (int k = 0; k < kOrder; ++k) out.b[k] = spot.control(curve, first + k);
  return out;
}

/// Interval of x in a curve. A spot that remembers the last one brings an overload.
template <class Spot>
int piece_at(const SplineView& view, const Spot&, int /*curve*/, double x) noexcept {
  return find_piece(view, x);
}

/// Sum of a spot's control values times the basis at x, on a basis of a known order: the compiler
/// unrolls it, which is half of a tick's time.
template <int kOrder, class T, class Spot>
T curve_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* c = view.weights + piece * kOrder * kOrder;
  T sum = live.b[0] * basis_value(c, kOrder, t);
  for (int k = 1; k < kOrder; ++k) sum = sum + live.b[k] * basis_value(c + k * kOrder, kOrder, t);
  return sum;
}

/// Force of one curve of a spot at x [m] -> [N]; exactly 0 for x <= 0.
template <class T, class Spot>
T curve_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return curve_of_order<2>(view, spot, curve, x);
    case 2:
      return curve_of_order<3>(view, spot, curve, x);
    case 3:
      return curve_of_order<4>(view, spot, curve, x);
    default:
      return curve_of_order<5>(view, spot, curve, x);
  }
}

/// Area under a curve of a spot up to the interval `piece` that the control values below `first`
/// bring. A spot that has it at hand brings an overload.
template <class Spot>
auto area_before(const SplineView& view, const Spot& spot, int curve, int piece, int first) noexcept
    -> decltype(spot.control(curve, first)) {
  using S = decltype(spot.control(curve, first));
  const double* whole = view.integrals + piece * view.size();
  S sum[4] = {S(0), S(0), S(0), S(0)};  // four at a time: one chain of sums would wait for each
  int j = 0;
  for (; j + 4 <= first; j += 4) {
    const auto live = live_controls<4>(spot, curve, j);
    for (int i = 0; i < 4; ++i) sum[i] = sum[i] + live.b[i] * whole[j + i];
  }
  for (int i = 0; j < first; ++j, ++i) sum[i] = sum[i] + spot.control(curve, j) * whole[j];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

template <int kOrder, class T, class Spot>
T energy_of_order(const SplineView& view, const Spot& spot, int curve, const T& x) noexcept {
  const int piece = piece_at(view, spot, curve, value_of(x)), first = first_control(view, piece);
  const auto live = live_controls<kOrder>(spot, curve, first);
  const T t = x - view.knots[piece];
  const double* whole = view.integrals + piece * view.size();
  const double* c = view.weights + piece * kOrder * kOrder;
  T last = T(0);
  for (int k = 0; k < kOrder; ++k)
    last = last + live.b[k] * (basis_integral(c + k * kOrder, kOrder, t) * t + whole[first + k]);
  return area_before(view, spot, curve, piece, first) + last;
}

/// Area under one curve of a spot from 0 to x [J], exact; 0 for x <= 0.
template <class T, class Spot>
T energy_at(const CurveViews& views, const Spot& spot, int curve, const T& x) noexcept {
  if (!(value_of(x) > 0)) return T(0);
  const SplineView& view = views.view[curve];
  switch (view.degree) {
    case 1:
      return energy_of_order<2>(view, spot, curve, x);
    case 2:
      return energy_of_order<3>(view, spot, curve, x);
    case 3:
      return energy_of_order<4>(view, spot, curve, x);
    default:
      return energy_of_order<5>(view, spot, curve, x);
  }
}

/// f^r(rho), times G(dz) where the body is coupled [N].
template <class T, class Spot>
T lateral_force(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
  const T force_N = curve_at(views, spot, kLateral, read_at_m(views, d));
  return views.coupling_depth_m > 0 ? d.gain.value * force_N : force_N;
}

/// Gradient of Z(dz) + G(dz) R(rho), force of the tool on the body [N] (docs/method.md, section 2):
/// (f^z + G' R - f pull . dl/d(dz)) u + f pull with f = G f^r; pull is u^r where the body is not
/// anisotropic. Zero where dz <= 0.
/// lateral_N: f, where the caller knows it already.
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
                 const T& lateral_N) noexcept {
  if (!(value_of(d.normal_m) > 0)) return {T(0), T(0), T(0)};
  T normal_N = curve_at(views, spot, kNormal, d.normal_m) - lateral_N * d.lean_rate;
  if (views.coupling_depth_m > 0)
    normal_N = normal_N + d.gain.slope * energy_at(views, spot, kLateral, read_at_m(views, d));
  return spot.normal * normal_N + (views.is_anisotropic ? d.pull : d.lateral) * lateral_N;
}
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
  return response(views, spot, d, lateral_force(views, spot, d));
}

}  // namespace runtime
}  // namespace palpate
