// Places and paths that are held out.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/validation/causes.hpp"
#include "tests/libfit/validation/held_out_body.hpp"

namespace palpate::validation {
namespace {

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

}  // namespace
}  // namespace palpate::validation
