// Surface without test points answers with the body's mean curves: no hole, no pop at the border,
// a flag, and the measured part as it was.

#include <gtest/gtest.h>

#include <set>

#include "tests/libfit/assets/changed_bytes.hpp"

namespace palpate::test {
namespace {

enum class Law { separable, rings };

class Elsewhere : public testing::TestWithParam<Law> {
 protected:
  // A sphere of 30 mm, stiffer towards +x, measured where z > 0.
  static Model half_sphere() {
    const auto scale = [](const Vec3& x) { return 1 + 25 * x[0]; };
    Model model = sphere_model(
        0.03, 24, [&](const Vec3& x) { return uniform(400 * scale(x), 300 * scale(x), 0.3)(x); });
    if (GetParam() == Law::rings)
      make_rings(model, 1, 0.03, scale, [](const Vec3&) { return Vec3(200, 0, 0); });
    uncover(model, [](const Vec3& x) { return x[2] <= 0; });
    return model;
  }
  Model model = half_sphere();
  Loaded none = load(model), mean = load(model, {.has_mean_elsewhere = true});
};

bool is_outside(const Output& out) { return (out.flags & PALPATE_FLAG_OUTSIDE) != 0; }

// At an angle [rad] from the pole +z in the plane x-z.
Vec3 at_angle(double angle, double radius_m) {
  return radius_m * Vec3(std::sin(angle), 0, std::cos(angle));
}

INSTANTIATE_TEST_SUITE_P(Every, Elsewhere, testing::Values(Law::separable, Law::rings),
                         [](const auto& law) {
                           return law.param == Law::rings ? "rings" : "separable";
                         });

TEST_P(Elsewhere, answers_with_the_mean_of_the_covered_curves_and_says_so) {
  Tool tool(mean.asset), hole(none.asset);
  const Vec3 below(0, 0.001, -0.026);
  const double force_N = tool.go({0, 0.001, -0.031}, below, 1e-4).norm();
  EXPECT_EQ(hole.go({0, 0.001, -0.031}, below, 1e-4), Vec3::Zero());
  EXPECT_NE(tool.out.state, ContactState::air);
  EXPECT_TRUE(is_outside(tool.out));
  double sum_N = 0, covered = 0;
  const SplineTables tables = tabulate(model.curves.basis[0]);
  const runtime::SplineView view{tables.degree, tables.pieces, tables.knots.data(),
                                 tables.weights.data(), tables.integrals.data()};
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    if (model.is_covered[static_cast<std::size_t>(v)]) {
      const std::vector<double> control(model.curves.control[0].row(v).begin(),
                                        model.curves.control[0].row(v).end());
      sum_N += runtime::curve_value(view, control.data(), tool.out.normal_m);
      ++covered;
    }
  EXPECT_NEAR(force_N, sum_N / covered, 0.02 * force_N);
}

TEST_P(Elsewhere, all_of_it_costs_one_row_of_controls) {
  const auto covered = std::count(model.is_covered.begin(), model.is_covered.end(), 1);
  for (const Loaded* body : {&none, &mean}) {
    EXPECT_EQ(body->asset.records, covered + 1);
    std::set<const float*> rows;
    for (int v = 0; v < body->asset.vertices; ++v)
      if (body->asset.covered[v] != runtime::kMeasured) rows.insert(body->asset.node(v));
    EXPECT_EQ(rows.size(), 1U);
  }
}

TEST_P(Elsewhere, changes_no_bit_of_what_is_measured) {
  Tool with(mean.asset), without(none.asset);
  for (int tick = 0; tick <= 1000; ++tick) {
    const double depth_m = 0.004 * std::min(1.0, tick / 300.0);
    const Vec3 x = at_angle(0.9 * tick / 1000, 0.0301 - depth_m);
    ASSERT_EQ(with.tick(x), without.tick(x)) << tick;
    ASSERT_EQ(with.out.flags, without.out.flags) << tick;
    ASSERT_FALSE(is_outside(with.out)) << tick;
  }
  EXPECT_EQ(with.out.state, ContactState::slip);
}

TEST_P(Elsewhere, has_no_hole_and_no_jump_at_the_border) {
  // From 60 to 120 degrees at a depth of 4 mm and 20 um a tick: the border is at 90.
  Tool tool(mean.asset), hole(none.asset);
  const double from = std::numbers::pi / 3, to = 2 * from, radius_m = 0.026;
  Vec3 before = tool.go(at_angle(from, 0.0305), at_angle(from, radius_m), 2e-5);
  hole.go(at_angle(from, 0.0305), at_angle(from, radius_m), 2e-5);
  const int ticks = static_cast<int>((to - from) * radius_m / 2e-5);
  const double start_N = before.norm();
  double max_step_N = 0, min_N = start_N, measured_step_N = 0;
  for (int tick = 1; tick <= ticks; ++tick) {
    const Vec3 x = at_angle(from + (to - from) * tick / ticks, radius_m), force = tool.tick(x);
    ASSERT_EQ(tool.status, Status::ok);
    hole.tick(x);
    const double step_N = (force - before).norm();
    max_step_N = std::max(max_step_N, step_N);
    if (!is_outside(tool.out)) measured_step_N = std::max(measured_step_N, step_N);
    min_N = std::min(min_N, force.norm());
    before = force;
  }
  EXPECT_TRUE(is_outside(tool.out));
  EXPECT_EQ(hole.out.state, ContactState::air) << "what users felt before";
  EXPECT_GT(min_N, 0.4 * start_N);
  EXPECT_LT(max_step_N, 3 * measured_step_N);
  RecordProperty("max_step_N", std::to_string(max_step_N));
}

TEST_P(Elsewhere, creates_no_energy_over_the_border) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    Tool tool(mean.asset);
    const double middle = std::numbers::pi / 2;
    Vec3 x = at_angle(middle, 0.0305);
    tool.tick(x);
    double max_J = 0;
    for (int leg = 0; leg < 12; ++leg) {
      const double angle = middle + 0.25 * share(random), aside_m = 0.004 * share(random);
      Vec3 next = at_angle(angle, 0.0275 + 0.002 * share(random)) + Vec3(0, aside_m, 0);
      if (leg == 11) next *= 0.032 / next.norm();
      for (int k = 1; k <= 40; ++k) {
        tool.tick(x + (next - x) * (k / 40.0));
        max_J = std::max(max_J, tool.out.stored_J);
        ASSERT_GE(tool.out.stored_J + tool.out.dissipated_J, -1e-12 * max_J) << "seed " << seed;
      }
      x = next;
    }
    EXPECT_GT(max_J, 1e-4) << "seed " << seed;
  }
}

TEST_P(Elsewhere, is_checked_along_measured_paths_alone) {
  int measured = 0;
  runtime::replay_check_path(mean.asset, [&](int, const Output& out) noexcept {
    if (out.state != ContactState::air) measured += is_outside(out) ? 0 : 1;
    return true;
  });
  EXPECT_GT(measured, mean.asset.check.ticks / 3);
}

TEST_P(Elsewhere, stands_in_the_asset_as_another_kind_of_vertex) {
  ExportReport report;
  AssetBytes bytes = make_asset_bytes(model, {.has_mean_elsewhere = true}, &report);
  EXPECT_GT(report.mean_vertices, 100);
  EXPECT_EQ(
      std::count(mean.asset.covered, mean.asset.covered + mean.asset.vertices, runtime::kMean),
      report.mean_vertices);
  EXPECT_NE(report.remarks.front().find("flags contact there as OUTSIDE"), std::string::npos);
  // A fourth kind is refused.
  const auto offset =
      reinterpret_cast<const unsigned char*>(mean.asset.covered) - mean.bytes.data();
  bytes.data()[offset] = 3;
  fix_checksum(bytes, bytes.size());
  EXPECT_EQ(open(bytes, bytes.size()), Status::controls_wrong);
}

}  // namespace
}  // namespace palpate::test
