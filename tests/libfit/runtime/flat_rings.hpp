// A body of rings on a plane on which nothing varies, and a tool on it.
#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/law/families.hpp"

namespace palpate::runtime {

inline RingAnchors<double> no_anchors() noexcept {
  RingAnchors<double> out;
  for (int i = 0; i < kRings; ++i) {
    out.set(i, {0, 0, 0});
    out.out[i] = 0;
  }
  return out;
}

// Curves of one piece or more with their tables.
struct Curve {
  SplineTables tables;
  SplineView view;
  std::vector<double> control;

  Curve(int degree, std::vector<double> knots, std::vector<double> b)
      : tables(tabulate(CurveBasis{degree, std::move(knots)})),
        view{tables.degree, tables.pieces, tables.knots.data(), tables.weights.data(),
             tables.integrals.data()},
        control(std::move(b)) {}
  Curve(const Curve&) = delete;
  Curve& operator=(const Curve&) = delete;
  double force(double d) const { return curve_value(view, control.data(), d); }
  double energy(double d) const { return curve_energy(view, control.data(), d); }
};

constexpr double kDepth_m = 8e-3;
// 12 d + 4500 d^2, as in the reference cases.
struct Quadratic : Curve {
  Quadratic() : Curve(2, {0, kDepth_m}, {0, 0.048, 12 * kDepth_m + 4500 * kDepth_m * kDepth_m}) {}
};
// Rises ever less: every ring but the first would be negative somewhere.
struct Concave : Curve {
  Concave() : Curve(3, {0, 3e-3, kDepth_m}, {0, 0.12, 0.21, 0.25, 0.27}) {}
};

struct Numbers {
  double lambda = 0.71, friction = 0.285, slope = 16, spread = 0, side2[3] = {}, side3[3] = {},
         curvature[6] = {}, sway[6] = {};
  const double* of(int part) const {
    const double* const at[] = {nullptr, &lambda, &friction, &slope, &spread,
                                side2,   side3,   curvature, sway};
    return at[part];
  }
};

template <class T>
struct FlatSpot {
  Vec3<T> point, normal;
  const Curve* curve;
  const Numbers* numbers;
  T control(int part, int j) const {
    return T(part == kNormal ? curve->control[static_cast<std::size_t>(j)] : numbers->of(part)[j]);
  }
};

template <class P>
struct FlatPath {
  Vec3<P> start, direction;
  Vec3d normal;
  const Curve* curve;
  const Numbers* numbers;
  double end() const { return 1e300; }
  bool is_blocked() const { return false; }
  bool is_straight() const { return true; }
  FlatPath<double> plain() const {
    return {values_of(start), values_of(direction), normal, curve, numbers};
  }
  template <class S>
  FlatSpot<S> at(const S& s) const {
    return {{start.x + direction.x * s, start.y + direction.y * s, start.z + direction.z * s},
            widened<S>(normal),
            curve,
            numbers};
  }
};

// A plane on which nothing varies.
template <class T>
struct FlatSurface {
  Vec3<T> c;
  Vec3d normal;
  const Curve* curve;
  const Numbers* numbers;
  FlatSpot<T> standing() const { return {c, widened<T>(normal), curve, numbers}; }
  FlatPath<T> aim(const FlatSpot<T>& spot, const Vec3<T>& direction) const {
    return {spot.point, direction, normal, curve, numbers};
  }
  bool is_spent() const { return false; }
  void move(const FlatPath<T>& path, const T& s) { c = path.start + path.direction * s; }
};

inline CurveViews views_of(const Curve& curve) {
  CurveViews views;
  views.family = static_cast<int>(Family::rings);
  views.view[kNormal] = curve.view;
  prepare(views);
  return views;
}

// What the engine and the fitter do at a tick.
template <class T>
Answer<T> tick(const CurveViews& views, FlatSurface<T>& surface, const Vec3<T>& x,
               Rings::Memory<T>& memory, SlideEnd* end = nullptr) {
  auto kinematics = Rings::kinematics(views, surface.standing(), x, memory);
  const Vec3<T> from = kinematics.spot.point;
  const SlideEnd how = slide<Rings>(views, x, surface, kinematics, memory);
  if (end != nullptr) *end = how;
  Rings::transport(views, memory, kinematics.spot.point - from, kinematics.spot.normal);
  kinematics = Rings::kinematics(views, surface.standing(), x, memory);
  const auto& bed = Rings::bed(views, kinematics);
  return Rings::answer(views, bed, kinematics, Rings::slip(views, bed, kinematics, memory));
}

// A tool on a plane, its contact point carried from place to place.
struct Bench {
  const Curve& curve;
  Numbers numbers;
  CurveViews views;
  FlatSurface<double> surface;
  Rings::Memory<double> memory = Rings::load<double>(no_memory());
  double dissipated_J = 0;

  explicit Bench(const Curve& of, const Numbers& with = {})
      : curve(of),
        numbers(with),
        views(views_of(of)),
        surface{{0, 0, 0}, {0, 0, -1}, &curve, &numbers} {}
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  Answer<double> answer(const Vec3d& x) const {
    const auto kinematics = Rings::kinematics(views, surface.standing(), x, memory);
    const auto& bed = Rings::bed(views, kinematics);
    return Rings::answer(views, bed, kinematics, Rings::stick(views, bed, kinematics, memory));
  }
  Answer<double> go(const Vec3d& x) {
    const double before_J = answer(x).stored_J;
    tick(views, surface, x, memory);
    const Answer<double> out = answer(x);
    dissipated_J += before_J - out.stored_J;
    return out;
  }
  Answer<double> go(double x, double y, double depth) { return go({x, y, -depth}); }
};

inline double size(const Vec3d& v) { return std::sqrt(dot(v, v)); }

}  // namespace palpate::runtime
