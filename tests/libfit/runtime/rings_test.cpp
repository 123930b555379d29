// The family of rings on flat, even bodies: its energy,
// its return map, what it remembers.

#include "libfit/runtime/families/families.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "libfit/core/curve_basis.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate::runtime {
namespace {

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
  double lambda = 0.71, friction = 0.285, slope = 16, side2[3] = {}, side3[3] = {},
         curvature[6] = {};
  const double* of(int part) const {
    const double* const at[] = {nullptr, &lambda, &friction, &slope, side2, side3, curvature};
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

CurveViews views_of(const Curve& curve) {
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
  Rings::carry(memory, kinematics.spot.point - from, kinematics.spot.normal);
  kinematics = Rings::kinematics(views, surface.standing(), x, memory);
  const auto& under = Rings::under(views, kinematics);
  return Rings::answer(views, under, kinematics, Rings::slip(views, under, kinematics, memory));
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
    const auto& under = Rings::under(views, kinematics);
    return Rings::answer(views, under, kinematics, Rings::stick(views, under, kinematics, memory));
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

double size(const Vec3d& v) { return std::sqrt(dot(v, v)); }

template <class Random>
Vec3d random_vector(Random& random, double scale) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  return {uniform(random), uniform(random), uniform(random)};
}

// A spot that leans and curves, with a side force.
Numbers random_numbers(std::mt19937_64& random) {
  Numbers numbers;
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 3; ++k) {
    numbers.side2[k] = 900 * uniform(random);
    numbers.side3[k] = 5e4 * uniform(random);
  }
  for (double& kappa : numbers.curvature) kappa = 40 * uniform(random);
  return numbers;
}

template <class C>
void expect_gradient(std::uint64_t seed) {
  const C curve;
  std::mt19937_64 random(seed);
  for (int trial = 0; trial < 200; ++trial) {
    const Numbers numbers = random_numbers(random);
    const auto table = ring_table<kRings>(curve.view, kDepth_m);
    const FlatSpot<double> spot{random_vector(random, 0.01), normalized(random_vector(random, 1)),
                                &curve, &numbers};
    const auto bed = ring_bed<double>(table, spot);
    auto anchors = no_anchors<double, kRings>();
    for (Vec3d& a : anchors.at) a = tangential(random_vector(random, 2e-3), spot.normal);
    if (trial % 2 == 0) anchors.at[0] = {0, 0, 0};
    const double depth = 9e-3 * std::uniform_real_distribution<double>()(random);
    const Vec3d x = spot.point + spot.normal * depth + random_vector(random, 2e-3);
    const auto energy = [&](const Vec3d& place) {
      const auto at = ring_deflection(spot, spot.numbers->curvature, place);
      return ring_answer(table, bed, at, ring_pull(bed, at, anchors), spot.normal, 0.0,
                         curve.energy(at.depth_m))
          .stored_J;
    };
    const auto at = ring_deflection(spot, spot.numbers->curvature, x);
    if (at.depth_m < 1e-5) continue;
    const Vec3d force = ring_answer(table, bed, at, ring_pull(bed, at, anchors), spot.normal,
                                    curve.force(at.depth_m), 0.0)
                            .force_N;
    const double h = 1e-6;
    const Vec3d slope{energy(x + Vec3d{h, 0, 0}) - energy(x - Vec3d{h, 0, 0}),
                      energy(x + Vec3d{0, h, 0}) - energy(x - Vec3d{0, h, 0}),
                      energy(x + Vec3d{0, 0, h}) - energy(x - Vec3d{0, 0, h})};
    EXPECT_LT(size(slope * (0.5 / h) - force), 2e-6 * (1 + size(force)))
        << "seed " << seed << " trial " << trial;
  }
}

TEST(Rings, force_is_the_gradient_of_the_energy) { expect_gradient<Quadratic>(1); }
TEST(Rings, force_is_the_gradient_of_the_energy_where_the_curve_is_concave) {
  expect_gradient<Concave>(2);
}

// T = mu [f(d) - f(d - lambda r / mu)].
template <int N>
double loading_error(double depth) {
  const Quadratic curve;
  const Numbers numbers;
  const auto table = ring_table<N>(curve.view, kDepth_m);
  FlatSpot<double> spot{{0, 0, 0}, {0, 0, -1}, &curve, &numbers};
  const auto bed = ring_bed<double>(table, spot);
  auto anchors = no_anchors<double, N>();
  double worst = 0;
  const double mu = 0.285 + 16 * depth;
  for (int k = 0; k <= 40; ++k) {
    const double r = 5e-3 * k / 40;
    const Vec3d x{r, 0, -depth}, before = spot.point;
    spot.point.x = std::max(spot.point.x, r - mu * depth / 0.71);  // ring 1 slips
    carry_anchors(anchors, spot.point - before, spot.normal);
    slip_rings(table, bed, ring_deflection(spot, spot.numbers->curvature, x), anchors);
    const double force =
        ring_pull(bed, ring_deflection(spot, spot.numbers->curvature, x), anchors).force_N.x;
    const double expected = mu * (curve.force(depth) - curve.force(depth - 0.71 * r / mu));
    worst = std::max(worst, std::fabs(force - expected));
  }
  return worst;
}

TEST(Rings, first_loading_tends_to_the_continuous_bed) {
  EXPECT_LT(loading_error<8>(6e-3), 8e-4);
  EXPECT_LT(loading_error<64>(6e-3), 2e-5);
  EXPECT_LT(loading_error<1024>(6e-3), 1e-7);
}

TEST(Rings, first_loading_is_the_sum_of_rings_that_hold_or_slip) {
  const Quadratic curve;
  Bench bench(curve);
  const double depth = 5e-3, mu = 0.285 + 16 * depth;
  bench.go(0, 0, depth);
  const auto bed = ring_bed<double>(bench.views.rings, bench.surface.standing());
  for (int k = 1; k <= 40; ++k) {
    const double r = 5e-3 * k / 40;
    double expected = 0;
    for (int i = 0; i < kRings; ++i) {
      const double reach = std::max(depth - bench.views.rings.threshold_m[i], 0.0);
      expected += bed.stiffness_N_m[i] * std::min(r, mu * reach / 0.71);
    }
    EXPECT_NEAR(bench.go(r, 0, depth).force_N.x, expected, 1e-13);
  }
}

TEST(Rings, unloading_follows_masings_rule) {
  const Quadratic curve;
  const double depth = 6e-3, turn = 2.5e-3;
  std::vector<double> first;
  {
    Bench loading(curve);
    loading.go(0, 0, depth);
    for (int k = 1; k <= 50; ++k) first.push_back(loading.go(turn * k / 50, 0, depth).force_N.x);
  }
  Bench bench(curve);
  bench.go(0, 0, depth);
  bench.go(turn, 0, depth);
  for (int k = 1; k <= 50; ++k)
    EXPECT_NEAR(bench.go(turn - 2 * turn * k / 50, 0, depth).force_N.x,
                first.back() - 2 * first[static_cast<std::size_t>(k) - 1], 1e-13);
}

// Independent values (40 digits of care, another language); see the shared cases' README.
void expect_reference(const std::string& name) {
  PALPATE_NEEDS_DATA("cases/rings");
  std::ifstream file(testing_support::shared_data("cases/rings") / (name + ".csv"));
  const Quadratic curve;
  Bench bench(curve);
  std::string line;
  std::getline(file, line);
  std::getline(file, line);
  double peak = 0, worst = 0, worst_J = 0;
  int rows = 0;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    double x, y, depth, tx, ty, fz, stored, dissipated;
    ASSERT_TRUE(row >> x >> y >> depth >> tx >> ty >> fz >> stored >> dissipated);
    const auto out = bench.go(x, y, depth);
    const double normal_J = depth > 0 ? curve.energy(depth) : 0;
    peak = std::max({peak, std::fabs(tx), std::fabs(ty), fz});
    worst = std::max({worst, std::fabs(out.force_N.x - tx), std::fabs(out.force_N.y - ty),
                      std::fabs(-out.force_N.z - std::max(fz, 0.0))});
    worst_J = std::max({worst_J, std::fabs(out.stored_J - normal_J - stored),
                        std::fabs(bench.dissipated_J - dissipated)});
    ++rows;
  }
  EXPECT_GT(rows, 50);
  EXPECT_LT(worst, 1e-12 * peak);
  EXPECT_LT(worst_J, 1e-12 * peak * kDepth_m);
}

TEST(Rings, load_is_the_references) { expect_reference("load"); }
TEST(Rings, turn_is_the_references) { expect_reference("turn"); }
TEST(Rings, retract_is_the_references) { expect_reference("retract"); }
TEST(Rings, wander_is_the_references) { expect_reference("wander"); }

// Work of the tool at anchors held during each move, the law's own energy, not the sampling's.
TEST(Rings, closed_loops_create_no_energy_at_any_tick_length) {
  const Quadratic quadratic;
  const Concave concave;
  constexpr std::uint64_t kSeed = 31;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform;
  for (int loop = 0; loop < 300; ++loop) {
    const Curve& curve = loop % 3 == 2 ? static_cast<const Curve&>(concave) : quadratic;
    Numbers numbers;  // flat and even
    const double friction = std::pow(10, -3 * uniform(random));
    numbers.friction *= friction;
    numbers.slope *= friction;
    Bench bench(curve, numbers);
    const double step_m = std::pow(10, -6 + 4 * uniform(random));  // 1 um to 1 cm
    double work_J = 0, moved_J = 0;
    Vec3d x{0, 0, 0};
    double stored_J = 0;
    for (int leg = 0; leg < 7; ++leg) {
      const Vec3d to = leg == 6 ? Vec3d{0, 0, 1e-4}
                                : Vec3d{5e-3 * (2 * uniform(random) - 1),
                                        5e-3 * (2 * uniform(random) - 1), -7e-3 * uniform(random)};
      const int ticks = std::clamp(static_cast<int>(size(to - x) / step_m), 1, 1000);
      const Vec3d from = x;
      for (int k = 1; k <= ticks; ++k) {
        x = from + (to - from) * (double(k) / ticks);
        const double held_J = bench.answer(x).stored_J;
        work_J += held_J - stored_J;
        moved_J += std::fabs(held_J - stored_J);
        stored_J = bench.go(x).stored_J;
        EXPECT_LE(stored_J, held_J + 1e-15) << "seed " << kSeed << " loop " << loop;
      }
    }
    EXPECT_LT(stored_J, 1e-30);
    EXPECT_GT(work_J, -1e-13 * moved_J) << "seed " << kSeed << " loop " << loop;
  }
}

TEST(Rings, force_has_no_jump_where_rings_attach_or_release) {
  const Quadratic curve;
  Bench bench(curve);
  bench.go(0, 0, 7e-3);
  bench.go(2e-3, 1e-3, 7e-3);
  // Steepest: f^z' with all of friction.
  const double stiffness = 2 * (12 + 9000 * kDepth_m), step = 1e-7;
  Vec3d before = bench.go(2e-3, 1e-3, 7e-3).force_N;
  double largest = 0;
  for (int way = -1; way <= 1; way += 2)
    for (int k = 0; k <= 70000; ++k) {  // out of contact and back
      const double depth = way < 0 ? 7e-3 - step * k : step * k;
      const Vec3d force = bench.go(2e-3, 1e-3 + 0.01 * step * k, depth).force_N;
      largest = std::max(largest, size(force - before));
      before = force;
    }
  EXPECT_LT(largest, stiffness * step);
}

TEST(Rings, rings_of_a_concave_curve_bear_the_curve) {
  const Concave curve;
  const Numbers numbers;
  const auto table = ring_table<kRings>(curve.view, kDepth_m);
  const auto bed =
      ring_bed<double>(table, FlatSpot<double>{{0, 0, 0}, {0, 0, 1}, &curve, &numbers});
  EXPECT_TRUE(bed.is_cut);
  for (double depth = 2e-4; depth < 9e-3; depth += 1e-4) {
    double kept = 0;
    for (int i = 0; i < kRings; ++i) {
      EXPECT_GE(bed.stiffness_N_m[i], 0);
      kept += bed.stiffness_N_m[i] / 0.71 * std::max(depth - table.threshold_m[i], 0.0);
    }
    const double share = ring_share(table, bed, depth).value;
    EXPECT_GT(share, 0);
    EXPECT_LE(share, 1);
    EXPECT_NEAR(share * kept, curve.force(depth), 0.06 * curve.force(kDepth_m));
  }
}

// The law with derivatives by the tool's place, stick, partial slip and gross slip alike.
TEST(Rings, tangent_is_the_slope_of_what_a_tick_answers) {
  const Quadratic curve;
  constexpr std::uint64_t kSeed = 5;
  std::mt19937_64 random(kSeed);
  const CurveViews views = views_of(curve);
  int slid = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Numbers numbers = random_numbers(random);
    const Vec3d normal = normalized(random_vector(random, 1));
    auto anchors = no_anchors<double, kRings>();
    for (Vec3d& a : anchors.at) a = tangential(random_vector(random, 1e-3), normal);
    anchors.at[0] = {0, 0, 0};
    const Vec3d x = normal * 4e-3 + random_vector(random, 3e-3);
    double held[Rings::kMemory];
    Rings::save(anchors, held);
    const auto answer = [&](auto tip) {
      using T = decltype(tip.x);
      FlatSurface<T> surface{{T(0), T(0), T(0)}, normal, &curve, &numbers};
      auto memory = Rings::load<T>(held);
      SlideEnd end;
      const Vec3<T> force = tick(views, surface, tip, memory, &end).force_N;
      slid += end == SlideEnd::slid;
      return force;
    };
    const Vec3<Jet3> force =
        answer(Vec3<Jet3>{Jet3(x.x, 1, 0, 0), Jet3(x.y, 0, 1, 0), Jet3(x.z, 0, 0, 1)});
    const double h = 1e-8;
    for (int k = 0; k < 3; ++k) {
      const Vec3d e{k == 0 ? h : 0, k == 1 ? h : 0, k == 2 ? h : 0};
      const Vec3d slope = (answer(x + e) - answer(x - e)) * (0.5 / h);
      const Vec3d exact{force.x.v[k], force.y.v[k], force.z.v[k]};
      EXPECT_LT(size(slope - exact), 1e-3 * (1 + size(exact)))
          << "seed " << kSeed << " trial " << trial;
    }
  }
  EXPECT_GT(slid, 100);
}

TEST(Rings, a_flat_slip_leaves_ring_1_at_its_limit) {
  const Quadratic curve;
  Bench bench(curve);
  bench.go(0, 0, 5e-3);
  const Vec3d x{9e-3, 2e-3, -5e-3};
  bench.go(x);
  const double limit_m = (0.285 + 16 * 5e-3) * 5e-3 / 0.71;
  EXPECT_NEAR(size(bench.surface.c), std::hypot(9e-3, 2e-3) - limit_m, 1e-15);
}

}  // namespace
}  // namespace palpate::runtime
