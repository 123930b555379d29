// A body whose lateral stiffness grows with the root of depth: the coupled families.

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kRange_m = 0.01;

// 400 N/m down and, at full depth, 300 N/m aside. leans: along x with the square of depth.
Model coupled_plate(double mu, bool leans = false) {
  Model model = plate_model(0.1, 20, uniform(400, 300, mu));
  model.curves.is_coupled = true;
  if (!leans) return model;
  model.curves.lean_basis = {2, {0, kRange_m}};
  model.curves.lean = Controls::Zero(model.surface.vertices.rows(), 9);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.curves.lean(v, 6) = 0.003 * (1 + 6 * model.surface.vertices(v, 0));
  return model;
}

double gain(double depth_m) { return runtime::gain_at(kRange_m, depth_m).value; }

TEST(coupled, the_gain_is_the_root_of_depth_with_a_slope_at_zero) {
  EXPECT_EQ(gain(0), 0);
  EXPECT_NEAR(gain(kRange_m), 1, 1e-15);
  for (const double share : {0.1, 0.3, 0.5, 0.9})
    EXPECT_NEAR(gain(share * kRange_m), std::sqrt(share), 1e-3) << share;
  for (const double depth_m : {1e-9, 1e-6, 1e-4, 3e-3, 0.02}) {
    const auto slope = runtime::gain_at(kRange_m, runtime::Dual(depth_m, 1)).value.v;
    const double step_m = 1e-4 * (depth_m + 1e-8);
    const double difference = (gain(depth_m + step_m) - gain(depth_m - step_m)) / (2 * step_m);
    EXPECT_NEAR(slope, difference, 1e-6 * slope) << depth_m;
    EXPECT_NEAR(slope, runtime::gain_at(kRange_m, depth_m).slope, 1e-12 * slope) << depth_m;
  }
}

TEST(coupled, lateral_stiffness_grows_with_the_gain_and_the_normal_force_pays_for_it) {
  const Loaded plate = load(coupled_plate(1e6));
  Tool tool(plate.asset);
  for (const double depth_m : {0.001, 0.004, 0.009}) {
    tool.go({0, 0.001, 0.001}, {0, 0.001, -depth_m}, 1e-4);
    const double aside_m = 0.0008;
    const Vec3 force = tool.go({0, 0.001, -depth_m}, {aside_m, 0.001, -depth_m}, 1e-4);
    EXPECT_NEAR(force[0], 300 * gain(depth_m) * aside_m, 1e-6) << depth_m;
    const double rate_1_m = runtime::gain_at(kRange_m, depth_m).slope;
    EXPECT_NEAR(-force[2], 400 * depth_m + rate_1_m * 150 * aside_m * aside_m, 1e-5) << depth_m;
    tool.go({aside_m, 0.001, -depth_m}, {0, 0.001, 0.001}, 1e-4);
  }
}

TEST(coupled, force_is_the_gradient_of_the_stored_energy) {
  for (const bool leans : {false, true}) {
    const Loaded plate = load(coupled_plate(1e6, leans));
    Tool tool(plate.asset);
    expect_force_is_energy_gradient(tool, {0.011, 0.001, -0.005}, leans ? 13 : 12);
  }
}

TEST(coupled, slips_end_at_the_limit_and_lift_off_without_a_pop) {
  const Loaded plate = load(coupled_plate(0.3, true));
  Tool tool(plate.asset);
  tool.go({-0.02, 0.001, 0.001}, {-0.02, 0.001, -0.005}, 5e-5);
  tool.go({-0.02, 0.001, -0.005}, {0.02, 0.006, -0.005}, 5e-5);
  EXPECT_EQ(tool.out.state, ContactState::slip);
  const double limit_N = 0.3 * 400 * tool.out.normal_m;
  EXPECT_NEAR(300 * gain(tool.out.normal_m) * tool.out.lateral_m, limit_N, 1e-6 * limit_N);
  expect_lift_off_without_a_pop(tool, {0.02, 0.006, -0.005});
}

TEST(coupled, only_such_an_asset_asks_for_version_3_and_version_2_has_no_flag_for_it) {
  Model separable = coupled_plate(0.3);
  separable.curves.is_coupled = false;
  runtime::Header header;
  const Loaded plain = load(separable);
  std::memcpy(&header, plain.bytes.data(), sizeof header);
  EXPECT_EQ(header.version, 2U);
  Loaded plate = load(coupled_plate(0.3));
  std::memcpy(&header, plate.bytes.data(), sizeof header);
  EXPECT_EQ(header.version, 3U);
  for (const auto& [version, flags] :
       {std::pair{2U, header.flags}, std::pair{3U, header.flags | runtime::kFlagAnisotropic}}) {
    runtime::Header changed = header;
    changed.version = version, changed.flags = flags;
    std::memcpy(plate.bytes.data(), &changed, sizeof changed);
    changed.checksum = runtime::asset_checksum(plate.bytes.data(), plate.bytes.size());
    std::memcpy(plate.bytes.data(), &changed, sizeof changed);
    Status status;
    Asset::open(plate.bytes.data(), plate.bytes.size(), &status);
    EXPECT_EQ(status, Status::layout_wrong) << version;
  }
}

}  // namespace
}  // namespace palpate::test
