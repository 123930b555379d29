// Seeded slides over bodies in closed form, and what devices do with them.

#include <gtest/gtest.h>

#include "libfit/certify/certificate.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::certify::test {
namespace {

using namespace palpate::test;

Model plate(double friction, const std::function<double(const Vec3&)>& scale,
            const Vec3& side_N_m2 = Vec3::Zero()) {
  Model model = plate_model(0.08, 8, uniform(400, 300, 0.3));
  make_rings(model, friction, 0, scale, [&](const Vec3&) { return side_N_m2; });
  return model;
}
double uneven(const Vec3& x) { return 1 + 0.8 * std::sin(200 * x[0]); }

Certificate certify(const Model& model, std::uint64_t seed = 1) {
  return palpate::certify::certify(load(model).asset, {.slides = 60, .seed = seed});
}

TEST(certificate, an_even_plate_needs_no_guard_and_an_uneven_one_without_friction_does) {
  const Certificate sound = certify(plate(1, even)), slippery = certify(plate(0.02, uneven));
  EXPECT_GT(sound.ticks, 5000);
  EXPECT_EQ(sound.held_ticks, 0);
  EXPECT_EQ(sound.refused_J, 0);
  EXPECT_GT(sound.work_J, 0);
  EXPECT_GT(slippery.held_ticks, slippery.ticks / 100);
  EXPECT_GT(slippery.refused_J, 1e-3 * slippery.work_J);
}

TEST(certificate, is_the_same_for_a_seed_and_another_for_another) {
  const Model model = plate(0.3, uneven);
  EXPECT_EQ(certify(model).refused_J, certify(model).refused_J);
  EXPECT_EQ(certify(model).ticks, certify(model).ticks);
  EXPECT_NE(certify(model).ticks, certify(model, 2).ticks);
}

// mu(d) d / lambda 2 g_2 d against f^z = 12 d + 4500 d^2, up to d = 1 cm (M22).
TEST(certificate, a_side_force_beyond_the_normal_one_pulls) {
  for (const double side_N_m2 : {20.0, 2000.0, 60000.0}) {
    const double reach_m = (0.285 + 0.16) * 0.01 / 0.71 + 1e-4;
    const bool pulls = 2 * side_N_m2 * 0.01 * reach_m > 12 * 0.01 + 4500 * 1e-4;
    EXPECT_EQ(certify(plate(1, even, Vec3(side_N_m2, 0, 0))).is_passive_fixed(), !pulls)
        << side_N_m2;
  }
}

// The stiffness of a plate steps over one row of edges, and the largest jump is found there.
TEST(certificate, names_the_place_of_the_largest_jump_over_an_edge) {
  const Certificate c = certify(plate(1, [](const Vec3& x) { return x[0] < 0.021 ? 1.0 : 8.0; }));
  EXPECT_GT(c.jumps.edge_N, 0);
  EXPECT_GT(c.edge_jump_at_m[0], 0.01);
}

// A spring of 300 N/m under a zero-order hold and a device of mass m with just less than K T / 2 of
// damping gains energy; with just more it does not.
TEST(certificate, half_of_stiffness_times_period_is_the_damping_that_a_hold_needs) {
  constexpr double kStiffness_N_m = 300, kMass_kg = 0.05, kRate_Hz = 1000;
  for (const double share : {0.98, 1.02}) {
    const double b = share * least_damping_Ns_m(kStiffness_N_m, kRate_Hz);
    // x'' = -(K x_k + b x') / m over a period, exactly.
    const double T = 1 / kRate_Hz, rate = b / kMass_kg, fade = std::exp(-rate * T);
    double x = 1e-3, v = 0;
    for (int k = 0; k < 200000; ++k) {
      const double drift = -kStiffness_N_m * x / b;  // the speed that it tends to
      x += drift * T + (v - drift) * (1 - fade) / rate;
      v = drift + (v - drift) * fade;
    }
    if (share < 1)
      EXPECT_GT(std::hypot(x, v * std::sqrt(kMass_kg / kStiffness_N_m)), 2e-3);
    else
      EXPECT_LT(std::hypot(x, v * std::sqrt(kMass_kg / kStiffness_N_m)), 5e-4);
  }
}

TEST(certificate, devices_are_judged_by_force_stiffness_and_resolution) {
  const Device device{"d", "", 3, 1000, 5e-5, 0.02};
  EXPECT_TRUE(judge(device, 800, 3).resolution_fits);  // 800 N/m 25 um = 0.02 N
  EXPECT_FALSE(judge(device, 801, 3).resolution_fits);
  EXPECT_FALSE(judge(device, 1001, 3).stiffness_fits);
  EXPECT_FALSE(judge(device, 800, 3.1).force_fits);
  EXPECT_TRUE(judge({"unknown", ""}, 1e6, 1e3).force_fits);
}

}  // namespace
}  // namespace palpate::certify::test
