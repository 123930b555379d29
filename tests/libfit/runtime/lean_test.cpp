// A body that gives way sideways when pressed: the leaning family.

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kRange_m = 0.01;

// A plate whose lean is a parabola in depth, all of it along x, scaled from place to place.
Model leaning_plate(double mu, double lean_at_range_m, double change_1_m) {
  Model model = plate_model(0.1, 20, uniform(400, 300, mu));
  Controls& lean = make_leaning(model, {0, kRange_m});
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    lean(v, 6) = lean_at_range_m * (1 + change_1_m * model.surface.vertices(v, 0));  // b_1 = 0: x^2
  return model;
}

double lean_m(double depth_m, double at_range_m) {
  return at_range_m * depth_m * depth_m / (kRange_m * kRange_m);
}

TEST(lean, a_straight_press_is_pushed_back_by_the_lateral_curve_at_the_lean) {
  const Loaded plate = load(leaning_plate(1e6, 0.003, 0));
  Tool tool(plate.asset);
  for (const double depth_m : {0.001, 0.004, 0.009}) {
    const Vec3 force = tool.go({0, 0.001, 0.001}, {0, 0.001, -depth_m}, 1e-4);
    const double l = lean_m(depth_m, 0.003), slope = 2 * l / depth_m;
    EXPECT_NEAR(force[0], -300 * l, 1e-6) << depth_m;
    EXPECT_NEAR(force[1], 0, 1e-9) << depth_m;
    // What the lateral spring stores is paid for by the normal force.
    EXPECT_NEAR(-force[2], 400 * depth_m + 300 * l * slope, 1e-5) << depth_m;
    tool.go({0, 0.001, -depth_m}, {0, 0.001, 0.001}, 1e-4);
  }
}

TEST(lean, a_tool_that_goes_along_with_the_body_feels_the_normal_curve_alone) {
  const Loaded plate = load(leaning_plate(1e6, 0.003, 0));
  Tool tool(plate.asset);
  tool.tick({0, 0.001, 1e-6});
  tool.tick({0, 0.001, -1e-9});
  for (int i = 1; i <= 80; ++i) {
    const double depth_m = 1e-4 * i;
    const Vec3 force = tool.tick({lean_m(depth_m, 0.003), 0.001, -depth_m});
    EXPECT_NEAR(std::hypot(force[0], force[1]), 0, 1e-5) << i;
    EXPECT_NEAR(-force[2], 400 * depth_m, 1e-5) << i;
  }
}

TEST(lean, force_is_the_gradient_of_the_stored_energy) {
  const Loaded plate = load(leaning_plate(1e6, 0.003, 6));
  Tool tool(plate.asset);
  expect_force_is_energy_gradient(tool, {0.011, 0.001, -0.005}, 11);
}

TEST(lean, slips_end_at_the_limit_and_lift_off_without_a_pop) {
  const Loaded plate = load(leaning_plate(0.3, 0.003, 6));
  Tool tool(plate.asset);
  tool.go({-0.02, 0.001, 0.001}, {-0.02, 0.001, -0.005}, 5e-5);
  tool.go({-0.02, 0.001, -0.005}, {0.02, 0.006, -0.005}, 5e-5);
  EXPECT_EQ(tool.out.state, ContactState::slip);
  const double limit_N = 0.3 * 400 * tool.out.normal_m;
  EXPECT_NEAR(300 * tool.out.lateral_m, limit_N, 1e-6 * limit_N);
  expect_lift_off_without_a_pop(tool, {0.02, 0.006, -0.005});
}

TEST(lean, zero_lean_brings_the_bits_of_the_separable_family) {
  Model leaning = leaning_plate(0.3, 0, 0);
  Model separable = leaning;
  separable.curves.family = CurveFamily::separable;
  separable.curves.basis.pop_back();
  separable.curves.control.pop_back();
  const Loaded a = load(leaning), b = load(separable);
  EXPECT_LT(b.bytes.size(), a.bytes.size());
  Tool one(a.asset), other(b.asset);
  for (int i = 0; i <= 400; ++i) {
    const double s = i / 400.0;
    const Vec3 tip(-0.02 + 0.04 * s, 0.01 * std::sin(9 * s), 0.0005 - 0.006 * s);
    EXPECT_EQ(one.tick(tip), other.tick(tip)) << i;
  }
}

// The byte offset of the lean's value j at vertex v.
std::size_t lean_offset(const Loaded& plate, int v, int j) {
  const auto& view = plate.asset;
  const auto* at = reinterpret_cast<const unsigned char*>(
      view.node(v) + view.control_offset[runtime::Leaning::kLean] + j);
  return static_cast<std::size_t>(at - plate.bytes.data());
}

TEST(lean, an_asset_whose_lean_is_not_zero_at_zero_or_not_finite_is_refused) {
  for (const auto& [j, value] : {std::pair{1, 1e-3F}, std::pair{7, INFINITY}}) {
    Loaded plate = load(leaning_plate(0.3, 0.003, 0));
    std::memcpy(plate.bytes.data() + lean_offset(plate, 30, j), &value, sizeof value);
    runtime::Header header;
    std::memcpy(&header, plate.bytes.data(), sizeof header);
    header.checksum = runtime::asset_checksum(plate.bytes.data(), plate.bytes.size());
    std::memcpy(plate.bytes.data(), &header, sizeof header);
    Status status;
    Asset::open(plate.bytes.data(), plate.bytes.size(), &status);
    EXPECT_EQ(status, Status::controls_wrong) << j;
  }
}

}  // namespace
}  // namespace palpate::test
