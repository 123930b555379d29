// Held-out paths, what an engine answers on them, and what is put in place of its curves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/runtime/series/quadric_replay.hpp"
#include "libfit/validation/causes.hpp"
#include "libfit/validation/replay.hpp"
#include "tests/support/bodies.hpp"

namespace palpate::validation {
namespace {

using tools::bench_cylinder;
using tools::BenchAsset;
using tools::cylinder_stiffness_N_m;
using tools::kCylinderRadius_m;
using tools::make_bench_asset;

const HeldOutRange kRange{0.006, 0.004};

Body cylinder_body() {
  Body body;
  body.surface = bench_cylinder(60, 40, 4).surface;
  for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v) {
    const double z = body.surface.vertices(v, 2);
    body.is_reachable.push_back(z > 0.02 && z < 0.08 && body.surface.vertices(v, 0) > 0);
  }
  return body;
}

TEST(HeldOut, points_are_uniform_by_area_within_what_can_be_reached) {
  const Body body = cylinder_body();
  const HeldOut held_out = draw_held_out(body, kRange, 4000, 3);
  int upper = 0;
  for (const auto& at : held_out.points.position.rowwise()) {
    EXPECT_GT(at.x(), -1e-12);
    EXPECT_GE(at.z(), 0.02);
    EXPECT_LE(at.z(), 0.08);
    EXPECT_NEAR(std::hypot(at.x(), at.y()), kCylinderRadius_m, 1e-4);
    upper += at.z() > 0.05;
  }
  EXPECT_NEAR(upper, 2000, 4 * std::sqrt(1000.0)) << "four standard deviations, seed 3";
}

TEST(HeldOut, slides_stay_where_one_can_reach) {
  const Body body = cylinder_body();
  double low = 1, high = 0;
  for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v) {
    if (!body.is_reachable[v]) continue;
    low = std::min(low, body.surface.vertices(v, 2));
    high = std::max(high, body.surface.vertices(v, 2));
  }
  const HeldOut held_out = draw_held_out(body, kRange, 400, 5);
  int near_border = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    const Vec3 at = held_out.points.position.row(i);
    near_border += std::min(at.z() - low, high - at.z()) < 0.3 * kRange.drag_distance_m;
    for (const auto& row : held_out.paths[i].deflections.rowwise()) {
      const double z = at.z() + row[2];  // normals have no part along the axis
      EXPECT_GT(z, low - 1e-9) << "seed 5, path " << i;
      EXPECT_LT(z, high + 1e-9) << "seed 5, path " << i;
    }
  }
  EXPECT_GT(near_border, 5) << "points from which not every direction stays";
}

TEST(HeldOut, points_lie_where_the_tool_can_touch_and_stay_where_they_all_do) {
  const Body body = cylinder_body();
  HeldOutRange range = kRange;
  range.can_touch = [](const Vec3& position, const Vec3& inward) {
    EXPECT_NEAR(inward.norm(), 1, 1e-12);
    return position.y() > 0;
  };
  const HeldOut held_out = draw_held_out(body, range, 100, 3);
  EXPECT_GT(held_out.points.position.col(1).minCoeff(), 0);
  EXPECT_LT(draw_held_out(body, kRange, 100, 3).points.position.col(1).minCoeff(), 0);
  range.can_touch = [](const Vec3&, const Vec3&) { return true; };
  EXPECT_EQ(draw_held_out(body, range, 100, 3).points.position,
            draw_held_out(body, kRange, 100, 3).points.position);
  range.can_touch = [](const Vec3&, const Vec3&) { return false; };
  EXPECT_THROW(draw_held_out(body, range, 1, 3), Error);
}

TEST(HeldOut, every_kind_of_path_comes_in_turn_and_starts_inward) {
  const HeldOut held_out = draw_held_out(cylinder_body(), kRange, 20, 1);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(static_cast<std::size_t>(held_out.paths[i].kind), i % kUprightKinds);
    const Points& path = held_out.paths[i].deflections;
    const Vec3 normal = held_out.points.normal.row(i);
    const Eigen::VectorXd depth = path * normal;
    const Eigen::VectorXd travel = (path - depth * normal.transpose()).rowwise().norm();
    EXPECT_GT(depth[0], 0);
    EXPECT_LE(depth.maxCoeff(), 0.95 * kRange.depth_m + 1e-12);
    EXPECT_GE(depth.maxCoeff(), 0.5 * kRange.depth_m - 1e-12);
    switch (held_out.paths[i].kind) {
      case PathKind::straight:
        EXPECT_LT(travel.maxCoeff(), 1e-12);
        break;
      case PathKind::oblique:
        EXPECT_NEAR(travel[5] / depth[5], travel[0] / depth[0], 1e-9);
        EXPECT_GT(travel[5] / depth[5], std::tan(19.9 * M_PI / 180));
        break;
      case PathKind::sliding:
        EXPECT_GT(travel[8], travel[5]);
        EXPECT_GT(depth[8], depth[5]) << "it goes on pressing while it slides";
        break;
      case PathKind::back_and_forth: {
        const Vec3 first = path.row(7) - path.row(3), last = path.row(13) - path.row(7);
        EXPECT_NEAR(first.normalized().dot(last.normalized()), -1, 1e-9);
        EXPECT_GT(last.norm(), 1.4 * first.norm()) << "back beyond where it began";
        break;
      }
      case PathKind::wandering: {
        ASSERT_EQ(path.rows(), 14) << "a press and six places, two rows each";
        EXPECT_LT(travel.head(2).maxCoeff(), 1e-12);
        EXPECT_LE(travel.maxCoeff(), kRange.drag_distance_m);
        EXPECT_GE(depth.minCoeff(), 0.2 * kRange.depth_m);
        for (const Eigen::Index at : {1, 5, 9}) {
          EXPECT_LT(depth[at + 2], depth[at]) << "retracted in part";
          EXPECT_GT(depth[at + 4], depth[at + 2]) << "pressed on";
        }
        const Vec3 one = path.row(5) - path.row(3), other = path.row(7) - path.row(5);
        EXPECT_GT(one.cross(other).norm(), 1e-3 * one.norm() * other.norm()) << "it turns";
        break;
      }
      case PathKind::tilting:
      case PathKind::none:
        ADD_FAILURE() << "nobody asked for leaning tools";
        break;
    }
  }
}

TEST(HeldOut, tilting_paths_come_last_and_change_no_other) {
  const Body body = cylinder_body();
  const HeldOut upright = draw_held_out(body, kRange, 12, 1);
  HeldOutRange range = kRange;
  range.tilt_rad = 0.8;
  int asked = 0;
  range.can_lean = [&](const Vec3&, const Vec3&, const Lean& lean) {
    ++asked;
    return lean.x() > 0;
  };
  const HeldOut tilting = draw_held_out(body, range, 12, 1);
  ASSERT_EQ(tilting.paths.size(), 15u) << "a fifth, rounded up";
  EXPECT_GT(asked, 3);
  for (std::size_t i = 0; i < 15; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(tilting.paths[i].kind == PathKind::tilting, i >= 12);
    if (i < 12) {
      EXPECT_EQ(tilting.points.position.row(row), upright.points.position.row(row));
      EXPECT_EQ(tilting.paths[i].deflections, upright.paths[i].deflections);
      EXPECT_TRUE(tilting.paths[i].lean.isZero());
    } else {
      EXPECT_GT(tilting.paths[i].lean.x(), 0);
      EXPECT_LT(tilting.paths[i].lean.norm(), std::sin(0.8));
      EXPECT_GT(tilting.paths[i].deflections.rows(), 5);
    }
  }
}

TEST(HeldOut, slides_are_drawn_where_the_force_of_a_press_changes_most) {
  const Body body = cylinder_body();
  const Surface& surface = body.surface;
  const BenchAsset bench = make_bench_asset(bench_cylinder(60, 40, 4));
  HeldOutRange range = kRange;
  range.change = press_changes(bench.asset, surface, 0.006);
  ASSERT_EQ(range.change.size(), surface.triangles.rows());
  // f^z is k(x) times a function of the depth.
  const auto slope = [](const Vec3& at, const Vec3& along) {
    return std::log(cylinder_stiffness_N_m(at + 1e-4 * along) /
                    cylinder_stiffness_N_m(at - 1e-4 * along)) /
           2e-4;
  };
  const auto change = [&](const Vec3& at) {
    return std::hypot(slope(at, Vec3::UnitZ()), slope(at, Vec3(-at.y(), at.x(), 0).normalized()));
  };
  double largest = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    largest = std::max(largest, change((a + b + c) / 3));
  }
  std::vector<double> reachable;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    EXPECT_NEAR(range.change[t], change((a + b + c) / 3), 0.05 * largest) << t;
    const auto corner = surface.triangles.row(t);
    if (std::ranges::all_of(corner, [&](auto v) { return body.is_reachable[v]; }))
      reachable.push_back(range.change[t]);  // triangles are of one size
  }
  std::ranges::sort(reachable);
  const HeldOut out = draw_sliding(body, range, 200, 1);
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_GT(change(out.points.position.row(i)),
              reachable[reachable.size() * 4 / 5] - 0.1 * largest);
    EXPECT_EQ(out.points.name[i][0], kChangeName);
    EXPECT_EQ(out.paths[i].kind, i % 2 == 0 ? PathKind::back_and_forth : PathKind::wandering);
  }
  EXPECT_EQ(draw_sliding(body, range, 9, 1).points.position, out.points.position.topRows(9));
}

TEST(HeldOut, the_body_and_the_seed_alone_decide) {
  Body body = cylinder_body();
  const HeldOut one = draw_held_out(body, kRange, 5, 1);
  body.test_points.position = Points::Zero(7, 3);
  EXPECT_EQ(draw_held_out(body, kRange, 5, 1).points.position, one.points.position);
  EXPECT_NE(draw_held_out(body, kRange, 5, 2).points.position, one.points.position);
}

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

TEST_F(Substituted, nothing_is_lost_where_every_vertex_is_a_test_point) {
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    model.blend_point.conservativeResize(v + 1, 3);
    model.blend_point.row(v).setConstant(static_cast<std::int32_t>(v));
  }
  model.blend_weight = Points::Zero(model.surface.vertices.rows(), 3);
  model.blend_weight.col(1).setOnes();
  const auto nearest = SubstitutedAsset::with_nearest_point(body.asset, model.curves, model);
  EXPECT_EQ(forces_of(nearest.view(), held_out), forces);
}

TEST_F(Substituted, a_linear_response_is_proportional_to_depth_and_right_at_its_depth) {
  const auto linear = SubstitutedAsset::linear(body.asset, 0.002);
  const auto& curved = body.asset.curves.view[0];
  for (const int vertex : {0, 700, 1500}) {
    const float* own = body.asset.node(vertex);
    const float* straight = linear.view().node(vertex);
    const double at_2mm = runtime::curve_value(curved, own, 0.002);
    for (const double depth_m : {0.001, 0.002, 0.005})
      EXPECT_NEAR(runtime::curve_value(curved, straight, depth_m), at_2mm * depth_m / 0.002,
                  1e-6 * at_2mm);
  }
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
  const auto baselines =
      baseline_errors(body.asset, reference, kRange.depth_m, 0.001, nullptr, nullptr);
  ASSERT_EQ(baselines.size(), 2u) << "without curves and model there is no nearest point";
  EXPECT_EQ(baselines[0].name, "one_response");
  EXPECT_GT(baselines[0].force.p95_rel, 0.05);  // stiffness varies by 30 % around
  EXPECT_EQ(baselines[1].name, "linear");
  EXPECT_GT(baselines[1].force.p95_rel, 0.3);  // f^z grows with the square of the depth
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

Samples one_row(const Vec3& force_N, const Vec3& torque_Nm) {
  Samples rows;
  rows.point_normal = Vec3(0, 0, 1).transpose();
  rows.point = {0};
  rows.status = {RowStatus::good};
  rows.deflection = Vec3(0.001, 0, 0.002).transpose();
  rows.force = force_N.transpose();
  rows.force_error = Eigen::VectorXd::Zero(1);
  rows.torque = torque_Nm.transpose();
  return rows;
}

double largest_share(const Vec3& reference_Nm, const Vec3& engine_Nm) {
  const Samples rows = one_row(Vec3::Zero(), reference_Nm);
  Replayed engine(rows);
  engine.is_answered = {1};
  engine.torque_Nm = engine_Nm.transpose();
  return summarize(compare(rows, engine, Levers{})).all.torque.max_rel;
}

TEST(Torque, of_a_soft_body_is_over_a_tenth_of_its_largest_and_of_none_has_no_share) {
  EXPECT_NEAR(largest_share(Vec3(1e-6, 0, 0), Vec3(1.2e-6, 0, 0)), 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(largest_share(Vec3::Zero(), Vec3(1e-6, 0, 0))));
}

TEST(Torque, is_about_the_centre_of_a_ball_where_a_force_through_it_does_not_count) {
  const Samples rows = one_row({1, 0, 5}, {0, 0.001, 0});
  Replayed engine(rows);
  engine.is_answered = {1};
  const Comparison of_ball = compare(rows, engine, Levers{0.01});
  ASSERT_EQ(of_ball.rows.size(), 1u);
  EXPECT_LT((of_ball.torque_Nm(0, 0.01) - Vec3(0, 0.011, 0)).norm(), 1e-15);
  const ErrorFigures error = summarize(of_ball).all.torque;
  EXPECT_NEAR(error.max, 0.011, 1e-15);
  EXPECT_NEAR(error.max_rel, 1, 1e-12);
  EXPECT_NEAR(summarize(compare(rows, engine, Levers{})).all.torque.max, 0.001, 1e-15);
}

// A straight press is turned by nothing, a side force by its lever: 100 N mm of 1 N at 100 mm.
TEST(Torque, at_a_handle_is_the_side_force_times_its_length_and_a_lean_moves_the_grip) {
  Samples rows = one_row({1, 0, 5}, Vec3::Zero());
  Replayed engine(rows);
  engine.is_answered = {1};
  engine.force_N = Vec3(0.8, 0, 6).transpose();
  const Levers held{0, 0.1};
  const StatedError upright = summarize(compare(rows, engine, held)).all;
  EXPECT_NEAR(upright.handle.typical, 0.1, 1e-15);
  EXPECT_NEAR(upright.handle.max, 0.02, 1e-15);
  EXPECT_NEAR(upright.handle.max_rel, 0.2, 1e-12);
  EXPECT_EQ(upright.torque.max, 0);
  // The shaft leans by the force's own angle: the grip lies behind it, and nothing turns the hand.
  rows.point_normal = Vec3(0, 0, -1).transpose();  // outward is z, where x and y are the tangents
  rows.force = Vec3(1, 0, -5).transpose();
  rows.lean = Eigen::Vector2d(-1, 0).transpose() / std::sqrt(26);
  EXPECT_NEAR(compare(rows, engine, held).torque_Nm(0, held.handle_m).norm(), 0, 1e-15);
  EXPECT_TRUE(std::isnan(summarize(compare(rows, engine, Levers{0.01})).all.handle.max));
}

// Coulomb's friction on a spring: the side force is min(k x, mu N).
TEST(SlipOnset, is_where_the_side_force_stops_growing_in_mm_and_newtons) {
  constexpr double kPush_N = 2, kStiffness_N_m = 400, kStep_m = 1e-4;
  Samples rows;
  rows.point_normal = Vec3(0, 0, 1).transpose();
  const int steps = 60;
  rows.deflection.resize(steps, 3);
  rows.force.resize(steps, 3);
  rows.force_error = Eigen::VectorXd::Zero(steps);
  for (int i = 0; i < steps; ++i) {
    const double x_m = kStep_m * (i < 40 ? i : 80 - i);  // it turns at 4 mm
    rows.point.push_back(0);
    rows.experiment.push_back(0);
    rows.path.push_back(PathKind::back_and_forth);
    rows.status.push_back(RowStatus::good);
    rows.deflection.row(i) << x_m, 0, 0.002;
    rows.force.row(i) << std::min(kStiffness_N_m * x_m, 0.3 * kPush_N), 0, kPush_N;
  }
  Replayed engine(rows);
  engine.is_answered.assign(steps, 1);
  engine.is_sliding.assign(steps, 1);
  for (int i = 0; i < steps; ++i)
    engine.force_N.row(i) << std::min(0.5 * kStiffness_N_m * rows.deflection(i, 0), 0.25 * kPush_N),
        0, kPush_N;
  const SlipOnset onset = summarize(compare(rows, engine)).slip_onset;
  EXPECT_EQ(onset.paths, 1u);
  // 0.9 of 0.6 N at 400 N/m are 1.35 mm, of 0.5 N at 200 N/m 2.25 mm.
  EXPECT_NEAR(onset.place_m.p95, 0.9e-3, 1e-9);
  EXPECT_NEAR(onset.force_N.p95, 0.9 * 0.1, 1e-9);
  engine.is_sliding.assign(steps, 0);
  EXPECT_EQ(summarize(compare(rows, engine)).slip_onset.paths, 0u) << "it sticks to the end";
  engine.is_sliding.assign(steps, 1);
  engine.force_N.col(0).setZero();
  EXPECT_EQ(summarize(compare(rows, engine)).slip_onset.paths, 0u) << "nothing holds it aside";
}

}  // namespace
}  // namespace palpate::validation
