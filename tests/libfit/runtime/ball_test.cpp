// A ball against facets, edges and vertices; how its reference point follows the contact.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

using runtime::Vec3d;

// Least distance from a point to the asset's surface, by looking at every triangle.
double distance_m(const Asset& asset, const Vec3& at) {
  const Vec3d p{at[0] - asset.origin_m[0], at[1] - asset.origin_m[1], at[2] - asset.origin_m[2]};
  double least = 1e300;
  for (int t = 0; t < asset.triangles; ++t) {
    Vec3d corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = asset.vertex_at(asset.corner(t, k)) - p;
    double n[3];
    runtime::closest_to_origin(corner[0], corner[1], corner[2], n);
    const Vec3d c = corner[0] * n[0] + corner[1] * n[1] + corner[2] * n[2];
    least = std::min(least, std::sqrt(dot(c, c)));
  }
  return least;
}

Loaded load_plate(double mu = 0.3) {
  return load(plate_model(0.1, 20, uniform(400, 300, mu)), {.max_step_m = 0.3});
}

TEST(ball, a_flat_body_is_touched_one_radius_above_it_at_any_speed) {
  const Loaded plate = load_plate(1e6);
  for (double step : {1e-5, 1e-3, 0.05, 0.2}) {
    Tool ball(plate.asset, 0.005);
    const Vec3 start(0.0012, 0.0007, 0.0051), way(0.3 * step, -0.1 * step, -step);
    Vec3 x = start;
    ball.tick(x);
    while (ball.out.state == ContactState::air && x[2] > -0.3) ball.tick(x += way);
    ASSERT_EQ(ball.out.state, ContactState::stick) << step;
    const double share = (0.0051 - 0.005) / step;  // of one way, from the start
    EXPECT_NEAR(ball.out.contact_m[0], start[0] + 0.3 * step * share, 1e-12) << step;
    EXPECT_NEAR(ball.out.contact_m[1], start[1] - 0.1 * step * share, 1e-12) << step;
    EXPECT_NEAR(ball.out.normal_m, 0.005 - x[2], 1e-12) << step;
    EXPECT_NEAR(ball.out.acts_at_m[2], x[2] - 0.005, 1e-12) << step;
  }
}

TEST(ball, first_touch_is_where_the_distance_first_falls_to_the_radius) {
  const Loaded sphere = load(sphere_model(0.03, 6, uniform(400, 300, 1e6)));
  std::mt19937 random(21);
  std::normal_distribution<double> gauss;
  int corners = 0, facets = 0;
  for (int round = 0; round < 400; ++round) {
    const Vec3 from = Vec3(gauss(random), gauss(random), gauss(random)).normalized() * 0.05;
    const Vec3 to = Vec3(gauss(random), gauss(random), gauss(random)).normalized() * 0.025;
    const double radius = 0.002 + 0.016 * (round % 7) / 7.0;
    const Vec3d p{from[0], from[1], from[2]}, q{to[0], to[1], to[2]};
    const auto entry = runtime::first_ball_entry(sphere.asset, p, q, radius);
    ASSERT_GE(entry.triangle, 0) << "seed 21, round " << round;
    EXPECT_NEAR(distance_m(sphere.asset, from + entry.along * (to - from)), radius, 1e-12)
        << "seed 21, round " << round;
    for (int i = 0; i < 50; ++i) {
      const Vec3 before = from + entry.along * i / 50.0 * (to - from);
      ASSERT_GT(distance_m(sphere.asset, before), radius) << "seed 21, round " << round;
    }
    const double least = std::min({entry.n[0], entry.n[1], entry.n[2]});
    (least == 0 ? corners : facets) += 1;
  }
  EXPECT_GT(corners, 20);
  EXPECT_GT(facets, 20);
}

TEST(ball, a_hollow_is_touched_by_facets_on_both_sides) {
  const Loaded valley = load(groove_model(0.1, 20, std::numbers::pi / 4));
  Tool ball(valley.asset, 0.004);
  ball.go({0.0002, 0.001, 0.01}, {0.0002, 0.001, 0.004}, 1e-5);
  ASSERT_NE(ball.out.state, ContactState::air);
  EXPECT_GT(ball.out.contact_m[0], 0.0025);  // a ball stands on the slopes, off the bottom
  EXPECT_NEAR(ball.out.contact_m[2], ball.out.contact_m[0], 1e-8);
}

// At an edge of a box, facets stand far above the surface of the blended normals, along which a
// ball lifts off. It used to be lost there: 225 of 674 contacts.
TEST(ball, one_that_lifted_off_at_an_edge_is_felt_when_it_presses_again) {
  const Loaded box = load(box_model(0.02, 8, uniform(400, 300, 0.3)));
  constexpr double kRadius_m = 0.005;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.019, 0.019);
  std::normal_distribution<double> gauss;
  int lifted = 0;
  double jump_N = 0;
  for (int round = 0; round < 200; ++round) {
    Tool ball(box.asset, kRadius_m);
    Vec3 x(place(random), place(random), place(random)), before = Vec3::Zero();
    const auto axis = static_cast<Eigen::Index>(random() % 3);
    const double side = random() % 2 == 0 ? 1 : -1;
    const auto go = [&](const Vec3& way, int ticks) {
      for (int i = 0; i < ticks; ++i) {
        const Vec3 force = ball.tick(x += way / ticks);
        jump_N = std::max(jump_N, (force - before).norm());
        before = force;
      }
    };
    x[axis] = side * (0.02 + kRadius_m + 1e-4);
    ball.tick(x);
    go(-side * 0.0031 * Vec3::Unit(axis), 150);
    Vec3 along(gauss(random), gauss(random), gauss(random));
    along[axis] = 0;
    go(0.012 * along.normalized(), 240);
    if (ball.out.state == ContactState::air) continue;
    const Vec3 up = -Vec3::Map(ball.out.normal);
    for (int i = 0; i < 1000 && ball.out.state != ContactState::air; ++i) go(1e-5 * up, 1);
    if (ball.out.state != ContactState::air) continue;
    ++lifted;
    EXPECT_EQ(before, Vec3::Zero()) << "seed 5, round " << round;
    go(-0.002 * up, 200);
    EXPECT_GT(before.norm(), 0.3) << "seed 5, round " << round;
  }
  EXPECT_GT(lifted, 100);
  EXPECT_LT(jump_N, 0.1);  // an ordinary tick of 50 um on 700 N/m: 0.035
}

TEST(ball, rolling_a_depth_around_a_round_body_keeps_the_depth) {
  // x = p + R u(c): the centre goes around at R + r - d, the force stays k d.
  const Loaded sphere = load(sphere_model(0.03, 60, uniform(400, 300, 0)));
  Tool ball(sphere.asset, 0.008);
  const auto at = [](double angle, double depth) {
    return Vec3((0.038 - depth) * std::sin(angle), 0.0001, (0.038 - depth) * std::cos(angle));
  };
  ball.go(at(0.3, -1e-4), at(0.3, 0.002), 1e-5);
  for (int i = 0; i <= 2000; ++i) {
    const Vec3 f = ball.tick(at(0.3 + 1e-3 * i, 0.002));
    ASSERT_NEAR(f.norm(), 0.8, 0.025)
        << i;  // facets' sagitta: 0.03 (1 - cos(0.026)) = 10 um, arms 3 um
    const Vec3 c = Vec3::Map(ball.out.contact_m);
    ASSERT_GT(c.normalized().dot(at(0.3 + 1e-3 * i, 0).normalized()), std::cos(0.03)) << i;
  }
}

// A ball of radius R whose centre is at the height h over the middle of a sphere and beside it by s
// touches it in the direction s / h, wherever friction does not hold the contact point.
TEST(ball, a_tip_on_a_body_that_was_measured_with_a_ball_is_that_ball) {
  constexpr double kBody_m = 0.03, kBall_m = 0.012, kDepth_m = 0.003, kAside_m = 0.008;
  Model model = sphere_model(kBody_m, 60, uniform(400, 300, 1e-3));
  const Loaded measured_with_tip = load(model);
  model.probe = sphere_spec(kBall_m);
  const Loaded measured_with_ball = load(model);
  const Vec3 touch(0, 0, kBody_m), up(0, 0, 1);
  const std::vector<Vec3> way = {touch + 0.001 * up, touch - kDepth_m * up,
                                 touch + Vec3(kAside_m, 0, -kDepth_m)};
  Tool tip(measured_with_ball.asset, 0), ball(measured_with_ball.asset, kBall_m),
      bare(measured_with_tip.asset, 0);
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Vec3 force = tip.go(way[i - 1], way[i], 2e-5);
    const Vec3 wanted = ball.go(way[i - 1] + kBall_m * up, way[i] + kBall_m * up, 2e-5);
    bare.go(way[i - 1], way[i], 2e-5);
    EXPECT_LT((force - wanted).norm(), 1e-9 * wanted.norm()) << "leg " << i;
    EXPECT_LT((Vec3::Map(tip.out.acts_at_m) - Vec3::Map(ball.out.acts_at_m)).norm(), 1e-12);
  }
  const auto angle = [](const Tool& at) {
    return std::atan2(at.out.contact_m[0], at.out.contact_m[2]);
  };
  EXPECT_NEAR(angle(tip), std::atan2(kAside_m, kBody_m + kBall_m - kDepth_m), 0.01);
  EXPECT_NEAR(angle(bare), std::atan2(kAside_m, kBody_m - kDepth_m), 0.01);
}

TEST(ball, a_tip_that_stands_for_a_ball_feels_nothing_where_it_touches) {
  Model model = sphere_model(0.03, 8, uniform(400, 300, 0.5));
  model.probe = sphere_spec(0.012);
  const Loaded body = load(model);
  std::mt19937 random(31);
  std::normal_distribution<double> gauss;
  for (int round = 0; round < 200; ++round) {
    const Vec3 out = Vec3(gauss(random), gauss(random), gauss(random)).normalized();
    Tool tip(body.asset, 0);
    Vec3 force = tip.tick(0.031 * out);
    for (double r = 0.031; tip.out.state == ContactState::air; r -= 1e-5) force = tip.tick(r * out);
    EXPECT_LT(force.norm(), 700 * 1.1e-5) << "round " << round;
  }
}

TEST(ball, a_vanishing_ball_is_a_tip) {
  const Loaded sphere = load(sphere_model(0.03, 20, uniform(400, 300, 0.3)));
  Tool ball(sphere.asset, 1e-9), nothing(sphere.asset, 0);
  Tool tip(sphere.asset);
  for (int i = 0; i < 3000; ++i) {
    const double t = i * 1e-3, r = 0.0295 + 0.001 * std::cos(9 * t);
    const Vec3 x(r * std::sin(t) * 0.8, r * 0.6 * std::sin(t), r * std::cos(t));
    const Vec3 f = tip.tick(x);
    ASSERT_LT((ball.tick(x) - f).norm(), 1e-4) << i;
    ASSERT_EQ(nothing.tick(x), f) << i;
  }
}

TEST(ball, one_that_begins_deep_inside_feels_nothing_until_it_came_out) {
  const Loaded sphere = load(sphere_model(0.03, 20, uniform(400, 300, 0.3)));
  for (double start : {0.0, 0.02, 0.028, 0.031, 0.033}) {
    Tool ball(sphere.asset, 0.005);
    const Vec3 out(0.48, 0.6, 0.64);
    for (int i = 0; i < 50; ++i) {
      ball.tick(out * (start + 0.0002 * std::sin(0.3 * i)));
      ASSERT_EQ(ball.out.state, ContactState::air) << start << ' ' << i;
      if (start > 0.0305) {  // its centre is outside
        ASSERT_EQ(ball.out.flags, PALPATE_FLAG_INSIDE) << start << ' ' << i;
      }
    }
    ball.go(out * start, out * 0.036, 1e-4);
    EXPECT_EQ(ball.out.state, ContactState::air) << start;
    EXPECT_EQ(ball.out.flags, 0U) << start;
    ball.go(out * 0.036, out * 0.033, 1e-4);
    EXPECT_NE(ball.out.state, ContactState::air) << start;
  }
}

TEST(ball, bad_radii_are_refused) {
  const Loaded plate = load_plate();
  for (double radius : {-1.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    Tool ball(plate.asset, radius);
    ball.tick({0, 0, -0.001});
    EXPECT_EQ(ball.status, Status::radius_wrong);
    EXPECT_EQ(ball.out.state, ContactState::air);
  }
}

TEST(ball, a_ball_larger_than_the_hollow_it_slides_in_stays_finite) {
  Model model = plate_model(0.1, 20, uniform(400, 300, 0.1));
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    const double x = model.surface.vertices(v, 0);
    model.surface.vertices(v, 2) = 0.002 * std::cos(x / 0.003);  // curvature radius 4.5 mm
    model.inward_normal.row(v) =
        Vec3(-0.002 / 0.003 * std::sin(x / 0.003), 0, -1).normalized().transpose();
  }
  const Loaded waves = load(model);
  for (double radius : {0.003, 0.006, 0.02, 0.2}) {
    Tool ball(waves.asset, radius);
    for (int i = 0; i < 6000; ++i) {
      const double x = -0.03 + 1e-5 * i;
      const Vec3 f = ball.tick({x, 0.0013, radius + 0.004 - 0.006 * std::min(1.0, i / 500.0)});
      ASSERT_EQ(ball.status, Status::ok);
      ASSERT_TRUE(f.allFinite()) << radius << ' ' << i;
      ASSERT_LT(f.norm(), 700 * 0.065) << radius << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace palpate::test
