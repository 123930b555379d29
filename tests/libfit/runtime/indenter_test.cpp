// Other round indenters on an asset that one ball identified (docs/method-tools.md, section 30),
// against closed forms of an even half-space.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "libfit/experiments/follow.hpp"
#include "libfit/runtime/engine.hpp"
#include "libfit/runtime/palpate.h"
#include "tests/libfit/runtime/c_face.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kBall_m = 0.008, kDepth_m = 0.007, kModulus_Pa = 12e3;  // E / (1 - nu^2)

Indenter cone(double half_angle_rad, double tip_m) {
  Indenter out;
  out.round_end_m = tip_m;
  out.points = 3;
  const double slope = 1 / std::tan(half_angle_rad), joint = tip_m * std::cos(half_angle_rad);
  out.r_m[1] = joint;
  out.r_m[2] = 0.5;
  out.slope[1] = out.slope[2] = slope;
  return out;
}
Indenter rod(double radius_m, double edge_m) {
  Indenter out;
  const double flat = radius_m - edge_m;
  for (const double share : {0.0, 1.0}) out.r_m[out.points++] = share * flat;
  for (int i = 1; i < 20; ++i) {
    const double angle = 1.45 * i / 19;
    out.r_m[out.points] = flat + edge_m * std::sin(angle);
    out.slope[out.points++] = std::tan(angle);
  }
  return out;
}
// Force on a half-space: 2 E* int a dd (Sneddon 1965).
double half_space_N(const Indenter& tool, double depth_m) {
  double sum = 0;
  constexpr int kSteps = 300;
  for (int i = 0; i < kSteps; ++i)
    sum += runtime::contact_radius_at(tool, depth_m * (i + 0.5) / kSteps) * depth_m / kSteps;
  return 2 * kModulus_Pa * sum;
}

// The ball's in closed form (Sneddon 1965), times (d/D)^stiffening.
double own_N(double depth_m, double stiffening) {
  const double a = runtime::contact_radius_at(runtime::ball_indenter(kBall_m), depth_m);
  return kModulus_Pa * ((a * a + kBall_m * kBall_m) * std::atanh(a / kBall_m) - a * kBall_m) *
         std::pow(depth_m / kDepth_m, stiffening);
}

// A plate that answers the ball so, on rows from kDepth_m / 14 on.
Model half_space_model(double friction = 0, double stiffening = 0) {
  Model model = plate_model(0.12, 24, uniform(400, 300, 0.3));
  make_rings(model, friction, 0, even);
  // Degree 1 through the exact curve on fine pieces: what a fit of exact rows would find.
  constexpr int kPieces = 70;
  model.curves.basis[0] = {1, {}};
  Controls& control = model.curves.control[0];
  control.resize(model.surface.vertices.rows(), kPieces + 1);
  for (int i = 0; i <= kPieces; ++i) {
    const double d = kDepth_m * i / kPieces;
    model.curves.basis[0].knots_m.push_back(d);
    control.col(i).setConstant(double(float(i == 0 ? 0 : own_N(d, stiffening))));
  }
  model.curves.first_row_m = kDepth_m / 14;
  model.probe = sphere_spec(kBall_m, friction);
  return model;
}

double press_N(const runtime::AssetView& asset, double depth_m) {
  Contact contact;
  Output out;
  for (int i = 0; i <= 700; ++i) {
    const double tip[3] = {0.001, 0.0004, 1e-4 - (1e-4 + depth_m) * i / 700};
    EXPECT_EQ(touch(asset, contact, tip, out), Status::ok);
  }
  return out.force_on_tool_N[2];
}

TEST(Indenter, elementary_functions_are_those_of_the_library) {
  for (double x = 1e-6; x < 1; x *= 1.07) {
    EXPECT_NEAR(runtime::atanh_of(x), std::atanh(x), 4e-15 * (1 + std::atanh(x))) << x;
    EXPECT_NEAR(runtime::asin_of(x), std::asin(x), 1e-14) << x;
  }
  for (double y = 1e-6; y < 30; y *= 1.1) {
    EXPECT_NEAR(runtime::tanh_of(y), std::tanh(y), 1e-13) << y;
    if (y > 1e-2) {
      EXPECT_NEAR(runtime::log_of(y), std::log(y), 1e-13) << y;
    }
  }
}

TEST(Indenter, depth_of_a_contact_is_that_of_closed_forms) {
  const double t = 0.001, alpha = std::numbers::pi / 3;
  Indenter paraboloid;
  paraboloid.round_end_m = kBall_m;
  paraboloid.points = 2;
  paraboloid.r_m[1] = 0.02;
  paraboloid.slope[1] = 0.02 / kBall_m;
  for (double a = 1e-5; a < 0.0079; a *= 1.2) {
    EXPECT_NEAR(runtime::depth_at(runtime::ball_indenter(kBall_m), a), a * std::atanh(a / kBall_m),
                1e-14 * kBall_m);
    EXPECT_NEAR(runtime::depth_at(paraboloid, a), a * a / kBall_m, 1e-14);
    // A cone far beyond its tip: pi/2 a cot(alpha), less what the round tip takes.
    if (a > 10 * t) {
      EXPECT_NEAR(runtime::depth_at(cone(alpha, t), a), std::numbers::pi / 2 * a / std::tan(alpha),
                  0.4 * t);
    }
  }
  EXPECT_EQ(runtime::depth_at(rod(0.005, 0.0005), 0.0045), 0);
  EXPECT_GT(runtime::depth_at(rod(0.005, 0.0005), 0.0046), 0);
  EXPECT_EQ(runtime::depth_at(runtime::ball_indenter(kBall_m), kBall_m), runtime::kNeverDeep_m);
  for (const Indenter& tool : {runtime::ball_indenter(0.003), cone(alpha, t), rod(0.005, 5e-4)})
    for (double d = 1e-5; d < 0.01; d *= 1.5) {
      const double a = runtime::contact_radius_at(tool, d);
      if (a < runtime::widest_m(tool) * (1 - 1e-9)) {
        EXPECT_NEAR(runtime::depth_at(tool, a), d, 1e-9 * d) << d;
      }
    }
}

TEST(Indenter, presses_an_even_half_space_as_closed_forms_have_it) {
  const Loaded loaded = load(half_space_model());
  IndenterAssets met(loaded.asset);
  EXPECT_EQ(met.of(runtime::ball_indenter(kBall_m)), nullptr);
  for (const auto& [tool, deepest_m] : {std::pair{runtime::ball_indenter(0.004), 0.006},
                                        {runtime::ball_indenter(0.012), 0.0038},
                                        {runtime::ball_indenter(0.016), 0.0027},
                                        {cone(1.05, 0.001), 0.007},
                                        {rod(0.005, 0.0005), 0.007}}) {
    const runtime::AssetView* view = met.of(tool);
    ASSERT_NE(view, nullptr);
    for (const double share : {0.02, 0.05, 0.1, 0.3, 0.6, 1.0}) {
      const double d = share * deepest_m, exact_N = half_space_N(tool, d);
      EXPECT_NEAR(press_N(*view, d), exact_N, 0.012 * exact_N)
          << tool.round_end_m << ", " << tool.points << " points, at " << d;
    }
  }
}

// Beyond the widest contact that was measured K goes on as of a half-space.
TEST(Indenter, wider_than_what_was_measured_is_said_and_goes_on_as_of_a_half_space) {
  const Loaded loaded = load(half_space_model());
  IndenterAssets met(loaded.asset);
  const Indenter tool = runtime::ball_indenter(0.012);
  const runtime::AssetView& view = *met.of(tool);
  EXPECT_NEAR(view.max_fitted_m,
              runtime::depth_at(
                  tool, runtime::contact_radius_at(runtime::ball_indenter(kBall_m), kDepth_m)),
              1e-9);
  EXPECT_NEAR(press_N(view, 0.006), half_space_N(tool, 0.006), 0.012 * half_space_N(tool, 0.006));
  Contact contact;
  Output out;
  for (int i = 0; i <= 700; ++i) {
    const double depth_m = -1e-4 + 1e-5 * i, tip[3] = {0.001, 0.0004, -depth_m};
    touch(view, contact, tip, out);
    if (out.state == ContactState::air) continue;
    EXPECT_EQ((out.flags & PALPATE_FLAG_EXTRAPOLATED) != 0, depth_m > view.max_fitted_m);
    EXPECT_EQ(out.flags & PALPATE_FLAG_OTHER_RADIUS, 0U);
  }
}

// Work that a loop aside takes which turns halfway to gross slip, by Mindlin and Masing. The edges
// of the rings lie over the depths that the tool is known for.
TEST(Indenter, slips_in_part_over_its_own_depths) {
  constexpr double kFriction = 0.4;
  Model model = half_space_model(kFriction);
  model.curves.control[runtime::kFriction].setConstant(kFriction);
  for (const int part : {runtime::kFrictionSlope, runtime::kSpread})
    model.curves.control[static_cast<std::size_t>(part)].setZero();
  const Loaded loaded = load(model);
  IndenterAssets met(loaded.asset);
  const double lambda = model.curves.control[runtime::kLambda](0, 0);
  for (const Indenter& tool : {runtime::ball_indenter(0.012), runtime::ball_indenter(0.016),
                               runtime::ball_indenter(0.004), cone(1.05, 0.001)}) {
    const runtime::AssetView& view = *met.of(tool);
    for (const double share : {1.0, 0.3}) {
      const double depth_m = share * view.max_fitted_m, turn_m = 0.5 * kFriction * depth_m / lambda;
      const auto first_N = [&](double r) {
        return kFriction *
               (half_space_N(tool, depth_m) - half_space_N(tool, depth_m - lambda * r / kFriction));
      };
      constexpr int kSteps = 200, kPieces = 10;
      double exact_J = -4 * turn_m * first_N(turn_m), work_J = 0;
      for (int i = 0; i < kPieces; ++i)
        exact_J += 8 * first_N(turn_m * (i + 0.5) / kPieces) * turn_m / kPieces;
      Contact contact;
      Output out;
      const auto go = [&](double aside_m, double deep_m) {
        const double tip[3] = {0.001 + aside_m, 0.0004, -deep_m};
        const double before_N = out.force_on_tool_N[0];
        EXPECT_EQ(touch(view, contact, tip, out), Status::ok);
        return -0.5 * (before_N + out.force_on_tool_N[0]);
      };
      for (int i = 0; i <= 700; ++i) go(0, -1e-4 + (1e-4 + depth_m) * i / 700);
      double at_m = 0;
      for (const double to_m : {turn_m, -turn_m, turn_m}) {
        for (int i = 1; i <= kSteps; ++i) {
          const double force_N = go(at_m + (to_m - at_m) * i / kSteps, depth_m);
          if (at_m != 0) work_J += force_N * (to_m - at_m) / kSteps;
        }
        at_m = to_m;
      }
      EXPECT_NEAR(work_J / exact_J, 1, share == 1 ? 0.25 : 0.18)
          << tool.round_end_m << ", " << tool.points << " points, at " << share;
    }
  }
}

// (M83): k multiplies the stiffness by 1 + ln(R/R0) k.
TEST(Indenter, radius_effect_goes_with_the_logarithm_of_the_radius) {
  Model model = half_space_model();
  model.curves.control[runtime::kRadiusEffect].col(0).setConstant(0.0625);
  const Loaded loaded = load(model), plain = load(half_space_model());
  IndenterAssets met(loaded.asset), without(plain.asset);
  for (const double radius_m : {0.004, 0.006, 0.012}) {
    const Indenter tool = runtime::ball_indenter(radius_m);
    for (const double d : {0.001, 0.0025}) {
      const double ratio = press_N(*met.of(tool), d) / press_N(*without.of(tool), d);
      EXPECT_NEAR(ratio, 1 + 0.0625 * std::log(radius_m / kBall_m), 2e-4) << radius_m;
    }
  }
}

// (M81): a body that stiffens answers another tool by its depth, by its contact's width, or by
// both.
TEST(Indenter, stiffness_goes_with_depth_or_with_width) {
  constexpr double kStiffening = 0.3;
  const Indenter ball = runtime::ball_indenter(kBall_m);
  const auto slope = [](double d) {
    return (own_N(d + 1e-6, kStiffening) - own_N(d - 1e-6, kStiffening)) / 2e-6;
  };
  for (const double w : {0.0, 0.25, 1.0}) {
    Model model = half_space_model(0, kStiffening);
    model.curves.control[runtime::kRadiusEffect].col(1).setConstant(w);
    const Loaded loaded = load(model);
    IndenterAssets met(loaded.asset);
    for (const Indenter& tool : {runtime::ball_indenter(0.004), runtime::ball_indenter(0.012),
                                 cone(1.05, 0.001), rod(0.005, 0.0005)})
      for (const double deepest_m : {0.002, 0.0035}) {
        double sum_N = 0;
        constexpr int kSteps = 200;
        for (int i = 0; i < kSteps; ++i) {
          const double d = deepest_m * (i + 0.5) / kSteps, a = runtime::contact_radius_at(tool, d);
          const auto stiffness = [&](double own_m) {  // below the first row as of a half-space
            return own_m < kDepth_m / 14
                       ? a * 2 * kModulus_Pa * own_N(kDepth_m / 14, kStiffening) /
                             own_N(kDepth_m / 14, 0)
                       : slope(own_m) * a / runtime::contact_radius_at(ball, own_m);
          };
          sum_N += ((1 - w) * stiffness(d) + w * stiffness(runtime::depth_at(ball, a))) *
                   deepest_m / kSteps;
        }
        EXPECT_NEAR(press_N(*met.of(tool), deepest_m), sum_N, 0.015 * sum_N)
            << "w " << w << ", " << tool.round_end_m << ", " << tool.points << " points, at "
            << deepest_m;
      }
  }
}

// Force is the slope of what is stored, for any indenter, at any depth and deflection.
TEST(Indenter, force_is_the_slope_of_what_is_stored) {
  Model model = half_space_model(0.4);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  model.curves.control[runtime::kSpread].setConstant(5);  // so that no ring slips outward
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.curves.control[runtime::kRadiusEffect].row(v) << float(0.1 * unit(random)),
        float(0.1 * unit(random));
  const Loaded loaded = load(model);
  IndenterAssets met(loaded.asset);
  for (const Indenter& tool : {runtime::ball_indenter(0.005), cone(1.05, 0.001), rod(0.005, 5e-4)})
    for (int i = 0; i < 40; ++i) {
      const runtime::AssetView& view = *met.of(tool);
      const double depth_m = 2e-4 + 0.006 * unit(random), h = 1e-7;
      double stored_J[3], force_N = 0;
      Output out;
      for (int k = 0; k < 3; ++k) {
        Contact contact;
        for (int step = 0; step <= 300; ++step) {
          const double tip[3] = {0.0011, 0.0007, 1e-4 - (1e-4 + depth_m) * step / 300};
          touch(view, contact, tip, out);
        }
        const double tip[3] = {0.0011, 0.0007, -depth_m - (k - 1) * h};
        touch(view, contact, tip, out);
        stored_J[k] = out.stored_J;
        if (k == 1) force_N = out.force_on_tool_N[2];
      }
      EXPECT_NEAR((stored_J[2] - stored_J[0]) / (2 * h), force_N, 1e-5 * force_N);
    }
}

TEST(Indenter, of_no_ball_or_twice_is_refused) {
  Model model = half_space_model();
  model.probe.reset();
  const Loaded unknown = load(model), known = load(half_space_model());
  IndenterAssets none(unknown.asset), met(known.asset);
  const Indenter small = runtime::ball_indenter(0.004);
  EXPECT_EQ(none.of(small), nullptr);
  ASSERT_NE(met.of(small), nullptr);
  EXPECT_FALSE(runtime::knows_radius(*met.of(small)));
  Indenter wrong = cone(1, 0.001);
  wrong.slope[2] = 0.1;  // hollow
  EXPECT_EQ(met.of(wrong), nullptr);
  EXPECT_EQ(met.of(runtime::ball_indenter(-1)), nullptr);
}

// A contact that one indenter began is not another's.
TEST(Indenter, contact_of_another_indenter_begins_anew) {
  const Loaded loaded = load(half_space_model());
  IndenterAssets met(loaded.asset);
  Contact contact;
  Output out;
  for (int i = 0; i <= 100; ++i) {
    const double tip[3] = {0.001, 0.0004, 1e-4 - 1e-5 * i};
    touch(*met.of(runtime::ball_indenter(0.004)), contact, tip, out);
  }
  ASSERT_GT(out.force_on_tool_N[2], 0);
  const double tip[3] = {0.001, 0.0004, -9e-4};
  EXPECT_EQ(touch(*met.of(runtime::ball_indenter(0.005)), contact, tip, out),
            Status::contact_foreign);
  EXPECT_EQ(out.force_on_tool_N[2], 0);
}

TEST(Indenter, is_the_same_through_the_c_interface) {
  const Loaded loaded = load(half_space_model());
  palpate_asset asset, met;
  ASSERT_EQ(palpate_open(&asset, loaded.bytes.data(), loaded.bytes.size()), PALPATE_OK);
  std::vector<std::uint64_t> memory(palpate_indenter_bytes(&asset) / 8);
  ASSERT_GT(memory.size(), 0U);
  palpate_indenter indenter = palpate_ball_indenter(0.004);
  const std::uint64_t bytes = 8 * memory.size();
  EXPECT_EQ(palpate_indenter_open(&met, &asset, &indenter, memory.data(), bytes - 8),
            PALPATE_TOOL_WRONG);
  EXPECT_EQ(palpate_indenter_open(&met, &asset, nullptr, memory.data(), bytes),
            PALPATE_NULL_ARGUMENT);
  palpate_indenter wrong = indenter;
  wrong.points = 1000;
  EXPECT_EQ(palpate_indenter_open(&met, &asset, &wrong, memory.data(), bytes), PALPATE_TOOL_WRONG);
  // A rod whose flat end is wider than the widest contact that was measured is known at no depth.
  const Indenter wide = rod(0.05, 0.001);
  wrong = palpate_indenter();
  wrong.points = wide.points;
  std::copy_n(wide.r_m, wide.points, wrong.r_m);
  std::copy_n(wide.slope, wide.points, wrong.slope);
  EXPECT_EQ(palpate_indenter_open(&met, &asset, &wrong, memory.data(), bytes), PALPATE_TOOL_WRONG);
  ASSERT_EQ(palpate_indenter_open(&met, &asset, &indenter, memory.data(), bytes), PALPATE_OK);
  EXPECT_EQ(palpate_indenter_bytes(&met), 0U);
  // In place of the asset, or as what one ball meets.
  for (const bool is_in_place : {true, false}) {
    palpate_tool tool = palpate_ball(0.004);
    if (!is_in_place) tool.ball_asset[0] = &met;
    palpate_contact contact;
    ASSERT_EQ(palpate_start(&contact, &tool), PALPATE_OK);
    palpate_output out;
    for (int i = 0; i <= 700; ++i) {
      const palpate_input in =
          palpate_input_at(0.001, 0.0004, 0.004 + 1e-4 - (1e-4 + 0.003) * i / 700, 0.001);
      ASSERT_EQ(palpate_tick(is_in_place ? &met : &asset, &contact, 1, &in, &out), PALPATE_OK);
    }
    const double exact_N = half_space_N(runtime::ball_indenter(0.004), 0.003);
    EXPECT_NEAR(out.force_on_tool_N[2], exact_N, 0.012 * exact_N);
    EXPECT_EQ(out.flags, 0U);
  }
}

// The curvature of the surface of a ball's centres is that of another one's by its principal radii.
TEST(Indenter, surface_of_centres_moves_out_with_the_radius) {
  const Vec3 n = Vec3(1, 2, -2).normalized(), t = n.unitOrthogonal(), b = n.cross(t);
  for (const auto& [r1, r2] : {std::pair{0.03, 0.05}, {0.03, 0.03}, {-0.02, 0.04}, {0.02, 1e9}}) {
    const Mat3 at = t * t.transpose() / r1 + b * b.transpose() / r2;
    for (const double surface_offset_m : {-0.004, 0.003}) {
      const Mat3 moved =
          t * t.transpose() / (r1 + surface_offset_m) + b * b.transpose() / (r2 + surface_offset_m);
      double kappa[6] = {at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)};
      runtime::offset_curvature(kappa, surface_offset_m);
      const double expected[6] = {moved(0, 0), moved(1, 1), moved(2, 2),
                                  moved(0, 1), moved(0, 2), moved(1, 2)};
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(kappa[i], expected[i], 1e-6 * moved.norm());
    }
  }
}

}  // namespace
}  // namespace palpate::test
