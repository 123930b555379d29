// How curves change with the indenter's radius, from presses of two indenters
// (docs/method-tools.md, section 30).

#include "libfit/fit/contact_effects.hpp"

#include <gtest/gtest.h>

#include <random>

#include "libfit/fit/point/replay.hpp"
#include "libfit/runtime/asset/with_indenter.hpp"

namespace palpate::test {
namespace {

constexpr double kOwnBall_m = 0.008, kPressed_m = 0.007;
constexpr int kInARow = 5;

// Five points in a row, each as a half-space of its own stiffness answers the ball, times
// (d/D)^stiffening.
FittedCurves half_spaces(double stiffening = 0) {
  FittedCurves out;
  out.position = Points::Zero(kInARow, 3);
  out.normal = Points::Zero(kInARow, 3);
  out.normal.col(2).setConstant(-1);
  out.status.assign(kInARow, FitStatus::good);
  out.probe = sphere_spec(kOwnBall_m, 0.3);
  out.curves = CurveSet(CurveFamily::rings);
  constexpr int kPieces = 40;
  out.curves.basis[0] = {1, {}};
  for (int i = 0; i <= kPieces; ++i)
    out.curves.basis[0].knots_m.push_back(kPressed_m * i / kPieces);
  const auto parts = parts_of(CurveFamily::rings);
  for (std::size_t k = 0; k < parts.size(); ++k)
    out.curves.control[k] =
        Controls::Zero(kInARow, parts[k].width * size_of(parts[k], out.curves.basis[k]));
  const Indenter ball = runtime::ball_indenter(kOwnBall_m);
  for (int p = 0; p < kInARow; ++p) {
    out.position(p, 0) = 0.01 * p;
    double force_N = 0;
    for (int i = 1; i <= kPieces; ++i) {
      force_N += 2e4 * (1 + 0.2 * p) *
                 runtime::contact_radius_at(ball, kPressed_m * (i - 0.5) / kPieces) * kPressed_m /
                 kPieces;
      out.curves.control[0](p, i) = float(force_N * std::pow(double(i) / kPieces, stiffening));
    }
  }
  out.curves.first_row_m = 0.0005;
  return out;
}

// Presses by a small ball, where the curves have k at each point.
Samples pressed(const FittedCurves& curves, const Controls& k, const Indenter& tool,
                const std::vector<int>& points, double noise, unsigned seed) {
  const fit::Bases bases = fit::bases_of(curves.curves);
  runtime::AssetView asset;
  asset.curves = bases.views;
  asset.probe_radius_m = kOwnBall_m;
  asset.first_row_m = curves.curves.first_row_m;
  std::vector<std::uint64_t> memory(runtime::indenter_bytes(asset) / 8);
  const runtime::AssetView met = runtime::with_indenter(asset, tool, memory.data());
  std::mt19937 random(seed);
  std::normal_distribution<double> unit;
  Samples out;
  out.point_position = curves.position;
  out.point_normal = curves.normal;
  constexpr int kSteps = 6;
  const auto rows = static_cast<Eigen::Index>(kSteps * points.size());
  out.deflection = out.force = out.torque = Points::Zero(rows, 3);
  out.force_error = Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
  struct Spot {
    const double* c;
    double control(int, int j) const { return c[j]; }
  };
  Eigen::Index row = 0;
  for (const int p : points)
    for (int step = 0; step < kSteps; ++step, ++row) {
      const double d = 0.0006 * (step + 1);
      const Spot spot{curves.curves.control[0].row(p).data()};
      const auto force = [&](const runtime::SplineView& view) {
        return runtime::piece_of(view, spot, 0, d, false).force(d);
      };
      const double as_deep = force(met.curves.view[0]);
      const double f = as_deep + k(p, 0) * force(met.curves.indenter->by_radius[0]) +
                       k(p, 1) * (force(met.curves.indenter->by_radius[1]) - as_deep);
      out.point.push_back(p);
      out.experiment.push_back(p);
      out.kind.push_back(ExperimentKind::other);
      out.probe_number.push_back(1);
      out.step.push_back(step);
      out.status.push_back(RowStatus::good);
      out.deflection(row, 2) = -d;
      out.force(row, 2) = -f * (1 + noise * unit(random));
    }
  return out;
}

Controls effect_of(const std::function<double(int)>& k) {
  Controls out = Controls::Zero(kInARow, runtime::kRadiusEffects);
  for (int p = 0; p < kInARow; ++p) out(p, 0) = k(p);
  return out;
}

TEST(radius_effect, is_found_again_in_presses_of_a_second_indenter) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    FittedCurves curves = half_spaces();
    const Controls k = effect_of([](int) { return 0.12; });
    fit::RadiusReport report;
    const Indenter tool = runtime::ball_indenter(0.004);
    fit::identify_radius_effect(curves, pressed(curves, k, tool, {0, 2, 4}, 0.003, seed), {tool},
                                &report);
    const Controls& found = curves.curves.control[runtime::kRadiusEffect];
    for (int p = 0; p < kInARow; ++p)
      EXPECT_NEAR(found(p, 0), 0.12, 0.02) << "seed " << seed << ", point " << p;
    EXPECT_EQ(report.points, 3U);
    EXPECT_LT(report.left_out.p95, 0.5 * report.theory.p95) << "seed " << seed;
    EXPECT_NE(report.chosen, "theory alone") << "seed " << seed;
  }
}

// Where points have nothing in common, those that were not pressed keep to theory.
TEST(radius_effect, of_points_that_disagree_is_not_spread) {
  FittedCurves curves = half_spaces();
  const Controls k = effect_of([](int p) { return p == 0 ? 0.2 : p == 2 ? -0.2 : 0.2; });
  fit::RadiusReport report;
  const Indenter tool = runtime::ball_indenter(0.004);
  fit::identify_radius_effect(curves, pressed(curves, k, tool, {0, 2, 4}, 0, 1), {tool}, &report);
  EXPECT_EQ(report.chosen, "theory alone");
  EXPECT_EQ(curves.curves.control[runtime::kRadiusEffect](1, 0), 0);
  EXPECT_GT(curves.curves.control[runtime::kRadiusEffect](0, 0), 0.05);
  EXPECT_LT(report.fitted.p95, report.theory.p95);
}

// (M83b), and w that presses of a second indenter tell otherwise.
TEST(radius_effect, of_a_body_that_stiffens_goes_with_width_unless_presses_tell) {
  for (const auto& [stiffening, w] : {std::pair{0.2, 1.0}, {-0.2, 0.0}, {0.0, 0.5}}) {
    FittedCurves curves = half_spaces(stiffening);
    const FittedCurves plain = curves;
    fit::identify_radius_effect(curves, Samples(), {});
    const Controls& found = curves.curves.control[runtime::kRadiusEffect];
    EXPECT_TRUE(found.col(0).isZero(0));
    EXPECT_LT((found.col(1).array() - w).abs().maxCoeff(), 0.02) << stiffening;
    if (stiffening == 0) continue;  // depth and width are one there
    Controls other = Controls::Zero(kInARow, runtime::kRadiusEffects);
    other.col(1).setConstant(0.4);
    const Indenter tool = runtime::ball_indenter(0.004);
    curves = plain;
    fit::identify_radius_effect(curves, pressed(curves, other, tool, {0, 2, 4}, 0.003, 1), {tool});
    EXPECT_LT((curves.curves.control[runtime::kRadiusEffect] - other).cwiseAbs().maxCoeff(), 0.1);
  }
}

TEST(radius_effect, of_curves_of_no_ball_is_none) {
  FittedCurves curves = half_spaces();
  const Indenter tool = runtime::ball_indenter(0.004);
  const Samples others = pressed(curves, effect_of([](int) { return 0.1; }), tool, {0, 1}, 0, 1);
  curves.probe.reset();
  fit::RadiusReport report;
  fit::identify_radius_effect(curves, others, {tool}, &report);
  EXPECT_EQ(report.points, 0U);
  EXPECT_TRUE(curves.curves.control[runtime::kRadiusEffect].isZero(0));
}

}  // namespace
}  // namespace palpate::test
