// What a bed of rings answers to presses, drags and turns on a plane is the theory's.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "libfit/runtime/series/quadric_replay.hpp"
#include "tests/libfit/runtime/flat_rings.hpp"

namespace palpate::runtime {
namespace {

// T = mu [f(d) - f(d - lambda r / mu)].
TEST(Rings, first_loading_is_near_that_of_the_continuous_bed) {
  const Quadratic curve;
  const double depth = 6e-3;
  const Numbers numbers;
  const auto table = ring_table(curve.view, kDepth_m);
  FlatSpot<double> spot{{0, 0, 0}, {0, 0, -1}, &curve, &numbers};
  const auto bed = ring_bed<double>(table, spot);
  auto anchors = no_anchors();
  double worst = 0;
  const double mu = 0.285 + 16 * depth, share = limit_share(table, bed, depth, curve.force(depth));
  for (int k = 0; k <= 40; ++k) {
    const double r = 5e-3 * k / 40;
    const Vec3d x{r, 0, -depth}, before = spot.point;
    spot.point.x = std::max(spot.point.x, r - share * mu * depth / 0.71);  // ring 1 slips
    transport_anchors(anchors, spot.point - before, spot.normal);
    ring_response<true>(table, bed, ring_deflection(spot, spot.numbers->curvature, x), anchors,
                        share);
    const double force =
        ring_response<false>(table, bed, ring_deflection(spot, spot.numbers->curvature, x), anchors)
            .force_N.x;
    const double expected = mu * (curve.force(depth) - curve.force(depth - 0.71 * r / mu));
    worst = std::max(worst, std::fabs(force - expected));
  }
  EXPECT_LT(worst, 8e-4);
}

// Radial friction (B1a): what a press that sticks bears beside f^z, in one tick or in many.
TEST(Rings, a_press_that_sticks_bears_what_spreads_its_rings) {
  const Quadratic curve;
  Numbers numbers;
  numbers.spread = 20;
  Bench bench(curve, numbers), at_once(curve, numbers);
  constexpr int kTicks = 500;
  for (int k = 1; k <= kTicks; ++k) {
    const double d = kDepth_m * k / kTicks;
    const Answer<double> pressed = bench.go(0, 0, d);
    if (k % 50 != 0) continue;
    const auto bed = ring_bed<double>(bench.views.rings, bench.surface.standing());
    double more = 0;
    for (int i = 1; i < kRings; ++i) {
      const double from = bench.views.rings.threshold_m[i];
      if (d > from) more += bed.stiffness_N_m[i] * 20 * (d * d - from * from) * 2 * 20 * d;
    }
    EXPECT_GT(more, 0);
    EXPECT_NEAR(-pressed.force_N.z, curve.force(d) + more, 1e-12);
  }
  EXPECT_NEAR(at_once.go(0, 0, kDepth_m).force_N.z, bench.answer({0, 0, -kDepth_m}).force_N.z,
              1e-12);
  EXPECT_NEAR(bench.dissipated_J, 0, 1e-15);
}

// Friction cannot hold a ring in all directions at once: as the tool slides, the press becomes that
// of a tool without friction. It stays so on the way back, and is anew after a lift.
TEST(Rings, a_slide_lets_go_of_what_a_press_has_spread) {
  const Quadratic curve;
  Numbers numbers;
  numbers.spread = 20;
  const auto go_aside = [](Bench& bench, double from, double to, double depth, int ticks) {
    Answer<double> out{{0, 0, 0}, 0};
    for (int k = 1; k <= ticks; ++k) out = bench.go(from + (to - from) * k / ticks, 0, depth);
    return -out.force_N.z;
  };
  for (const int ticks : {20, 2000}) {
    Bench bench(curve, numbers);
    const double d = 6e-3, even_N = curve.force(d), pressed_N = -bench.go(0, 0, d).force_N.z;
    EXPECT_GT(pressed_N, 1.01 * even_N);
    const double half_N = go_aside(bench, 0, 1e-3, d, ticks);
    EXPECT_LT(half_N, pressed_N);
    EXPECT_GT(half_N, even_N);
    EXPECT_NEAR(go_aside(bench, 1e-3, 0.02, d, ticks), even_N, 1e-3 * even_N);
    EXPECT_NEAR(go_aside(bench, 0.02, 0.018, d, ticks), even_N, 1e-3 * even_N);
    bench.go(0.018, 0, -1e-3);
    bench.surface.c = {0.018, 0, 0};  // the next contact begins there
    EXPECT_NEAR(-bench.go(0.018, 0, d).force_N.z, pressed_N, 1e-9);
    EXPECT_GT(bench.dissipated_J, 0);
  }
}

// f(d) for a ball's d^1.5 and for a curve that begins with a slope, as fitted ones do.
struct Hertz : Curve {
  Hertz() : Curve(4, knots(), controls()) {}
  static double at(double d) { return 400 * d * std::sqrt(d); }

 private:
  static std::vector<double> knots() {
    std::vector<double> out;
    for (int i = 0; i <= 32; ++i) out.push_back(kDepth_m * i * i / 1024.0);
    return out;
  }
  static std::vector<double> controls() {  // values at the knots' means: within 0.1 % of the curve
    const std::vector<double> knot = knots();
    std::vector<double> out;
    const int pieces = static_cast<int>(knot.size()) - 1;
    for (int j = 0; j < pieces + 4; ++j) {
      double mean = 0;
      for (int k = 1; k <= 4; ++k)
        mean += 0.25 * knot[static_cast<std::size_t>(std::clamp(j + k - 4, 0, pieces))];
      out.push_back(at(mean));
    }
    return out;
  }
};

constexpr double kShares[] = {0.03, 0.1, 0.3, 1};  // of the range of depths

// Coulomb: a tool that slides bears mu f^z at every depth, also where one ring touches.
TEST(Rings, friction_is_mu_times_the_normal_force_from_a_light_touch_on) {
  const Quadratic quadratic;
  const Hertz hertz;
  for (const Curve* curve :
       {static_cast<const Curve*>(&quadratic), static_cast<const Curve*>(&hertz)})
    for (const double share : kShares) {
      Bench bench(*curve);
      const double depth = share * kDepth_m, mu = 0.285 + 16 * depth;
      bench.go(0, 0, depth);
      double lateral_N = 0;
      for (int k = 1; k <= 100; ++k) lateral_N = bench.go(1e-4 * k, 0, depth).force_N.x;
      EXPECT_NEAR(lateral_N / (mu * curve->force(depth)), 1, 1e-9) << share;
    }
}

// First loading by Mindlin, T = mu [f(d) - f(d - lambda r / mu)], and its way back by Masing: the
// largest error over the span of the loop, 2 mu f. Eight rings with edges of the body's range leave
// two to touch at a tenth of it and one at 0.03 of it, where stick turns to slip at once.
TEST(Rings, partial_slip_is_mindlins_and_masings_where_several_rings_touch) {
  const Quadratic quadratic;
  const Hertz hertz;
  const double within[] = {0.3, 0.08, 0.03, 0.01};
  for (const Curve* curve :
       {static_cast<const Curve*>(&quadratic), static_cast<const Curve*>(&hertz)})
    for (int s = 0; s < 4; ++s) {
      const double depth = kShares[s] * kDepth_m, mu = 0.285 + 16 * depth;
      const double reach = mu * depth / 0.71, most = mu * curve->force(depth);
      const auto mindlin = [&](double r) {
        return most - mu * curve->force(std::max(depth - 0.71 * r / mu, 0.0));
      };
      for (const double turn : {0.3 * reach, 0.6 * reach, 0.9 * reach, 2 * reach}) {
        Bench bench(*curve);
        bench.go(0, 0, depth);
        double worst = 0;
        for (int k = 1; k <= 60; ++k)
          worst = std::max(worst, std::fabs(bench.go(turn * k / 60, 0, depth).force_N.x -
                                            mindlin(turn * k / 60)));
        for (int k = 1; k <= 120; ++k) {
          const double masing = mindlin(turn) - 2 * mindlin(0.5 * (turn * k / 60));
          worst = std::max(worst,
                           std::fabs(bench.go(turn - turn * k / 60, 0, depth).force_N.x - masing));
        }
        EXPECT_LT(worst / (2 * most), within[s]) << kShares[s] << " turned at " << turn / reach;
      }
    }
}

// Independent values, by make_rings.py beside them: another language, another way. Without (B3a) it
// brings those of the shared cases.
TEST(Rings, paths_are_those_of_another_language) {
  for (const std::string name : {"load", "turn", "retract", "wander"}) {
    SCOPED_TRACE(name);
    std::ifstream file(PALPATE_REFERENCE "/rings_" + name + ".csv");
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
}

TEST(Rings, rings_of_a_concave_curve_bear_the_curve) {
  const Concave curve;
  const Numbers numbers;
  const auto table = ring_table(curve.view, kDepth_m);
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

// The force stepped where the next ring touched, by up to 0.9 % on a liver that sways.
TEST(Rings, force_is_continuous_where_a_ring_of_a_concave_curve_touches) {
  const Concave curve;
  double most_N = 0;
  for (const double side : {2e-4, 1e-3, 3e-3})
    for (double depth = 5e-4; depth < 9e-3; depth += 5e-4) {
      Bench bench(curve);
      bench.go(0, 0, depth);
      bench.go(side, 0, depth);
      const auto& table = bench.views.rings;
      for (int i = 0; i < kRings; ++i)
        for (const double at : {table.threshold_m[i], table.edge_m[i]}) {
          const Vec3d below = bench.answer({side, 0, -(at - 1e-12)}).force_N,
                      above = bench.answer({side, 0, -(at + 1e-12)}).force_N;
          most_N = std::max(most_N, at > 0 ? size(above - below) : 0);
        }
    }
  RecordProperty("most_N", std::to_string(most_N));
  EXPECT_LT(most_N, 1e-6);
}

// The tool begins above a convex body and slides to where it touches: the limit begins on the way.
// A guess before that place sees a straight line to |q| = 0.
TEST(Rings, a_slip_ends_at_a_limit_that_begins_on_the_way_whatever_the_guess) {
  const Quadratic curve;
  Numbers numbers;
  for (int k = 0; k < 3; ++k) numbers.curvature[k] = 40;
  const CurveViews views = views_of(curve);
  ControlPointers<double> controls{{curve.control.data()}};
  for (int part = 1; part <= kSway; ++part) controls.part[part] = numbers.of(part);
  const Vec3d x{3e-3, 0, -1e-4};
  for (const double turn : {-1e-4, 1e-4})
    for (const double guess : {0.0, -0.3, -0.71, -0.72, -1.0, -2.7, -100.0}) {
      const Quadric quadric{{0, 0, -1}, {turn, 0, 0, 0, turn, 0, 0, 0, 0}};
      QuadricSurface<double> surface{&quadric, controls, {0, 0, 0}};
      auto memory = Rings::load<double>(no_memory());
      memory.slip_slope = guess;
      auto kinematics = Rings::kinematics(views, surface.standing(), x, memory);
      ASSERT_LT(kinematics.at.depth_m, 0);
      ASSERT_EQ(slide<Rings>(views, x, surface, kinematics, memory), SlideEnd::slid);
      const double excess_m = ring_slip_excess(surface.standing(), x, 0.0, 1.0);
      EXPECT_LT(std::fabs(excess_m), 1e-11 * 0.71 * 3e-3) << "guess " << guess << " turn " << turn;
    }
}

}  // namespace
}  // namespace palpate::runtime
