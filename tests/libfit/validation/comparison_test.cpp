// An engine's answers on held-out paths, and those of others in place of its curves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/runtime/series/quadric_replay.hpp"
#include "libfit/validation/causes.hpp"
#include "libfit/validation/replay.hpp"
#include "tests/libfit/validation/held_out_body.hpp"

namespace palpate::validation {
namespace {

// Rows of the held-out paths, without forces.
Samples rows_of(const HeldOut& held_out) {
  Samples s = planned_rows(paths_at(held_out.points, held_out.paths));
  s.status.assign(s.rows(), RowStatus::good);
  s.force_error.setConstant(0.001);
  return s;
}

Points forces_of(const runtime::AssetView& asset, const HeldOut& held_out) {
  return follow(asset, rows_of(held_out), kRange.depth_m).force_N;
}

class Substituted : public testing::Test {
 protected:
  Model model = bench_cylinder(60, 40, 4);
  BenchAsset body = make_bench_asset(model);
  HeldOut held_out = draw_held_out(cylinder_body(), kRange, 8, 1);
  Points forces = forces_of(body.asset, held_out);
};

TEST_F(Substituted, a_body_of_one_response_is_that_response_everywhere) {
  for (Controls& control : model.curves.control)
    control = control.row(500).replicate(control.rows(), 1).cast<float>().cast<double>();
  const BenchAsset even = make_bench_asset(model);
  const auto one = SubstitutedAsset::with_one_response(body.asset, model.curves, 500);
  EXPECT_EQ(forces_of(one.view(), held_out), forces_of(even.asset, held_out));
  EXPECT_GT((forces_of(even.asset, held_out) - forces).norm(), 1e-3);
}

TEST_F(Substituted, the_mean_response_leaves_a_body_of_one_response_as_it_is) {
  for (Controls& control : model.curves.control)
    control = control.row(500).replicate(control.rows(), 1).cast<float>().cast<double>();
  const BenchAsset even = make_bench_asset(model);
  const auto mean = SubstitutedAsset::with_mean_response(even.asset);
  EXPECT_EQ(forces_of(mean.view(), held_out), forces_of(even.asset, held_out));
}

// Samples that the law itself makes on a plate: every error must come out as what it is.
Samples samples_of(const runtime::AssetView& asset, const HeldOut& held_out) {
  Samples s = rows_of(held_out);
  s.force = forces_of(asset, held_out);
  return s;
}

std::vector<StatedError> by_path(const Reference& reference, const Replayed& engine,
                                 double radius_m) {
  const Comparison compared = compare(reference.paths, engine, Levers{radius_m});
  return errors_by(compared, floors_of(compared), kPathKindNames, [&](Eigen::Index row) {
    return static_cast<std::size_t>(reference.paths.path[row]);
  });
}

TEST_F(Substituted, baselines_and_paths_of_an_exact_reference_say_what_they_lose) {
  const Reference reference{samples_of(body.asset, held_out), {}, {}};
  const Replayed engine = follow(body.asset, reference.paths, kRange.depth_m);
  for (const StatedError& error : by_path(reference, engine, 0))
    EXPECT_EQ(error.force.p95, 0) << error.name;
  const auto baselines = baseline_errors(body.asset, reference, kRange.depth_m);
  ASSERT_EQ(baselines.size(), 1u);
  EXPECT_EQ(baselines[0].name, "one_response");
  EXPECT_GT(baselines[0].force.p95_rel, 0.05);  // stiffness varies by 30 % around
}

TEST_F(Substituted, causes_are_of_the_paths_whose_places_were_pressed) {
  const Reference paths{samples_of(body.asset, held_out), {}, {}};
  const auto causes_of_place = [&](Eigen::Index place) {
    HeldOut press;
    press.points.position = held_out.points.position.row(place);
    press.points.normal = held_out.points.normal.row(place);
    press.points.name = {"own"};
    Points way(8, 3);
    for (int k = 0; k < 8; ++k) way.row(k) = kRange.depth_m * (k + 1) / 8 * press.points.normal;
    press.paths.push_back({0, way});
    Reference reference = paths;
    reference.own = samples_of(body.asset, press);
    reference.own.kind.assign(8, ExperimentKind::press);
    return error_causes(body.asset, reference, follow(body.asset, paths.paths, kRange.depth_m),
                        kRange.depth_m, 1);
  };
  for (const Eigen::Index place : {0, 5}) {  // the straight ones
    const auto causes = causes_of_place(place);
    ASSERT_EQ(causes[2].name, "curve_family");
    EXPECT_EQ(causes[2].rows, 6u);
    EXPECT_LT(causes[2].force.max_rel, 0.02) << place;
  }
}

TEST_F(Substituted, rows_replayed_on_the_quadric_are_the_engines_on_a_press) {
  Samples presses = samples_of(body.asset, held_out);
  for (std::int32_t point = 0; point < 8; point += 5) {  // the straight ones
    const auto one = SubstitutedAsset::with_one_response(body.asset, model.curves, 500);
    const Points engine = forces_of(one.view(), held_out);
    Replayed replayed(presses);
    replay_point(presses, point, model.curves, 500, replayed);
    const auto rows = compare(presses, replayed).rows;
    ASSERT_EQ(rows.size(), 6u);
    for (const Eigen::Index row : rows)  // the tip enters the facet, below the round body
      EXPECT_LT((replayed.force_N.row(row) - engine.row(row)).norm(),
                0.02 * engine.row(row).norm() + 1e-3);
  }
}

// Presses whose forces are off a power law by up to 4 % of themselves and 5 mN.
TEST(OneFloor, a_fit_report_and_a_statement_of_the_same_rows_state_the_same_errors) {
  for (const double stiffness : {1.0, 0.01}) {  // largest force 3 N, 30 mN
    HeldOut presses;
    presses.points.position = Points::Random(3, 3);
    presses.points.normal = Points::Zero(3, 3);
    presses.points.normal.col(2).setOnes();
    presses.points.name = {"a", "b", "c"};
    for (int p = 0; p < 3; ++p) {
      Points way = Points::Zero(12, 3);
      way.col(2).setLinSpaced(12, 0.0002, 0.006);
      presses.paths.push_back({p, way});
    }
    Samples rows = rows_of(presses);
    rows.kind.assign(rows.kind.size(), ExperimentKind::press);
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      rows.force(i, 2) = stiffness * (3 * std::pow(rows.deflection(i, 2) / 0.006, 1.5) *
                                          (1 + 0.04 * std::sin(7.0 * double(i))) +
                                      0.005 * std::cos(3.0 * double(i)));
    FitReport report;
    const FittedCurves fitted = fit_curves(rows, options_for(rows), {}, &report);
    Replayed replayed(rows);
    for (std::int32_t p = 0; p < 3; ++p) replay_point(rows, p, fitted.curves, p, replayed);
    const Statement statement = summarize(compare(rows, replayed));
    EXPECT_GT(statement.rows_above_floor, 20u);
    EXPECT_LT(statement.rows_above_floor, 36u);
    EXPECT_GT(report.error.p95, 0.005);
    EXPECT_DOUBLE_EQ(report.error.median, statement.all.force.median_rel);
    EXPECT_DOUBLE_EQ(report.error.p95, statement.all.force.p95_rel);
    EXPECT_DOUBLE_EQ(report.error.max, statement.all.force.max_rel);
  }
}

TEST_F(Substituted, a_row_that_failed_is_not_compared_and_ends_a_path_replayed_by_the_law) {
  Reference reference{samples_of(body.asset, held_out), {}, {}};
  const auto all = static_cast<std::size_t>(reference.paths.rows());
  reference.paths.status[3] = RowStatus::not_converged;  // of the six of path 0
  reference.paths.force.row(3).setConstant(std::nan(""));
  const Replayed engine = follow(body.asset, reference.paths, kRange.depth_m);
  const Comparison compared = compare(reference.paths, engine);
  EXPECT_EQ(compared.rows.size(), all - 1);
  EXPECT_EQ(summarize(compared).all.force.max, 0) << "the engine passes the failed row on its way";
  Replayed by_law(reference.paths);
  replay_point(reference.paths, 0, model.curves, 500, by_law);
  EXPECT_EQ(compare(reference.paths, by_law).rows.size(), 3u);
}

TEST_F(Substituted, torques_of_an_exact_reference_have_no_error_and_all_of_it_without_torque) {
  Reference reference{samples_of(body.asset, held_out), {}, {}};
  const Replayed engine = follow(body.asset, reference.paths, kRange.depth_m);
  reference.paths.torque = engine.torque_Nm;
  constexpr double kRadius_m = 0.01;
  const auto exact = by_path(reference, engine, kRadius_m);
  ASSERT_EQ(exact.size(), 5u);
  EXPECT_EQ(exact[0].name, "straight");
  for (const StatedError& error : exact) EXPECT_EQ(error.torque.max, 0) << error.name;
  EXPECT_LT(exact[0].torque.typical, 0.05 * exact[2].torque.typical)
      << "a ball pressed straight is turned by nothing, one that slides by friction";
  const auto none = by_path(reference, Replayed(reference.paths), kRadius_m);
  EXPECT_TRUE(none.empty()) << "what was not replayed is not compared";
  Replayed numb(reference.paths);
  numb.is_answered = engine.is_answered;
  const ErrorFigures lost = summarize(compare(reference.paths, numb, Levers{kRadius_m})).all.torque;
  EXPECT_EQ(lost.median, lost.typical);
}

}  // namespace
}  // namespace palpate::validation
