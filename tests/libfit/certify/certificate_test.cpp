// What a certificate says of bodies in closed form.

#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

#include "libfit/certify/devices.hpp"
#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

// With the tool 2.5 mm deep the contact point goes over a facet that is 1 / (1 - d/R) times as long
// as the tool's way.
TEST(certificate, an_even_cylinder_needs_the_tangent_of_the_angle_between_normal_and_facet) {
  for (const int around : {25, 50, 100}) {
    const Loaded body = load(even_cylinder(around, 0.3));
    double bound = 0, found = 0;
    FacetOptions options;
    options.far = 0;
    for (int t = 8 * around; t < 8 * around + 8; ++t) {  // far from the open ends
      const Sliding sliding = certify_sliding(body.asset, t, OtherRings::any, options);
      bound = std::max(bound, sliding.ratio * sliding.friction);
      found = std::max(found, sliding.worst_found * sliding.friction);
    }
    const double mu = std::tan(std::numbers::pi / around) / (1 - 2.5 / 30);  // 0.138, 0.069, 0.034
    EXPECT_NEAR(found, mu, 0.02 * mu) << around;
    EXPECT_GT(bound, found) << around;
    EXPECT_LT(bound, 1.12 * mu) << around;
  }
}

/// Numbers of a facet, one of each kind that a bound reads.
std::vector<std::pair<const char*, double*>> numbers_of(Facet& e) {
  return {{"gradient", &e.gradient[1][0]},
          {"normal", &e.normal[2][1]},
          {"turn", &e.turn[0][1]},
          {"lambda", &e.lambda[1]},
          {"friction", &e.friction[2]},
          {"friction_slope", &e.friction_slope[0]},
          {"stiffness of ring 1", &e.stiffness[0][1]},
          {"stiffness of ring 2", &e.stiffness[1][1]},
          {"side2", &e.side2[0][2]},
          {"side3", &e.side3[1][2]},
          {"side2_turn", &e.side2_turn[0][0]},
          {"side3_turn", &e.side3_turn[1][1]},
          {"curvature", &e.curvature[3][0]},
          {"curvature_turn", &e.curvature_turn[1][2]},
          {"sway", &e.sway[0][1]},
          {"sway_turn", &e.sway_turn[0][3]},
          {"threshold", &e.threshold[1]},
          {"radius_m", &e.radius_m},
          {"overshoot_m", &e.overshoot_m}};
}
std::vector<std::pair<const char*, Interval*>> numbers_of(CurveTerms<Interval>& depth) {
  return {{"m", &depth.m},
          {"force", &depth.force[1]},
          {"force_slope", &depth.force_slope[0]},
          {"energy_slope", &depth.energy_slope[1]},
          {"bed", &depth.bed[2]}};
}

// No asset has one, for opening it refuses them; arithmetic might make one. It used to be larger
// than no ratio, and so the facet was certified.
TEST(certificate, certifies_nothing_where_a_number_is_none) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Model model = random_body(2, {1, 0.04, 1});
  for (const int axis : {0, 1, 2}) model.curves.control[runtime::kSway].col(axis).setConstant(1e-4);
  const Loaded body = load(model);
  int t = 0;
  while (zone_of(body.asset, t) != Zone::interior) ++t;
  FacetOptions options;
  options.radius_m = 0.004;
  const Facet facet = facet_of(body.asset, t, options);
  const double range_m = range_of(body.asset, t);
  const CurveTerms<Interval> depth =
      over_depths(body.asset, facet, t, 0.7 * range_m, 0.71 * range_m);
  const Patch patch{{{{0.34, 0.33, 0.33}}, {{0.33, 0.34, 0.33}}, {{0.33, 0.33, 0.34}}}};
  for (const OtherRings others : {OtherRings::any, OtherRings::sliding}) {
    ASSERT_LE(balance(facet, patch, depth, others).ratio, 1);
    Facet broken = facet;
    for (const auto& [name, number] : numbers_of(broken)) {
      const double kept = std::exchange(*number, kNone);
      EXPECT_FALSE(balance(broken, patch, depth, others).ratio <= 1) << name;
      *number = kept;
    }
    CurveTerms<Interval> unknown = depth;
    for (const auto& [name, range] : numbers_of(unknown)) {
      const Interval kept = std::exchange(*range, Interval(kNone));
      EXPECT_FALSE(balance(facet, patch, unknown, others).ratio <= 1) << name;
      *range = kept;
    }
  }
}

TEST(certificate, says_what_of_a_body_with_memory_and_of_several_contacts_it_leaves_to_the_guard) {
  Model model = random_body(2, {1, 0, 0});
  EXPECT_EQ(in_words(certify(load(model).asset)).find("left to the guard"), std::string::npos);
  model.curves.damage.r = 2;
  model.curves.damage.beta = 0.1;
  model.curves.damage.reach_m = 0.01;
  model.curves.coupling.length_m = 0.01;
  model.curves.coupling.give_m_N[0] = 1e-6;
  const Loaded body = load(model);
  const Certificate c = certify(body.asset);
  EXPECT_TRUE(c.softens);
  EXPECT_TRUE(c.couples);
  EXPECT_TRUE(c.certified()) << in_words(c);
  EXPECT_NE(in_words(c).find("nothing has pressed yet"), std::string::npos) << in_words(c);
  EXPECT_NE(in_words(c).find("of one by itself"), std::string::npos) << in_words(c);
}

TEST(certificate, is_the_same_for_every_number_of_threads) {
  const Loaded body = load(random_body(3, {1, 0.2, 0.5}));
  CertifyOptions options;
  options.facet.max_boxes = 40;
  options.continuity.walks = 3;
  const std::string one = in_words(palpate::certify::certify(body.asset, options));
  options.threads = 3;
  EXPECT_EQ(in_words(palpate::certify::certify(body.asset, options)), one);
}

TEST(certificate, tells_measured_triangles_from_those_beside_them) {
  Model model = random_body(2, {1, 0, 0});
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    if (model.surface.vertices(v, 0) > -0.005) continue;  // half of the plate is unknown
    model.is_covered[static_cast<std::size_t>(v)] = 0;
    for (Controls& control : model.curves.control) control.row(v).setZero();
  }
  const Loaded body = load(model);
  const Certificate c = certify(body.asset);
  EXPECT_TRUE(c.certified()) << in_words(c);
  int of[4] = {0, 0, 0, 0};
  for (int t = 0; t < body.asset.triangles; ++t) {
    int measured = 0;
    for (int k = 0; k < 3; ++k)
      measured += body.asset.covered[body.asset.corner(t, k)] == runtime::kMeasured;
    const Zone zone = c.zone[static_cast<std::size_t>(t)];
    EXPECT_EQ(zone, measured == 3            ? Zone::interior
                    : measured > 0           ? Zone::skirt
                    : body.asset.is_solid(t) ? Zone::mean
                                             : Zone::air);
    ++of[static_cast<int>(zone)];
  }
  EXPECT_EQ(of[int(Zone::interior)], c.interior);
  EXPECT_EQ(of[int(Zone::skirt)], c.skirt);
  EXPECT_EQ(of[int(Zone::mean)], c.mean);
  EXPECT_GT(c.skirt, 10);
  EXPECT_NEAR(c.skirt_area, double(c.skirt) / (c.skirt + c.interior + c.mean), 1e-6);  // all alike
}

TEST(certificate, of_a_share_of_the_depth_is_that_of_a_body_which_ends_there) {
  const Loaded body = load(random_body(2, {0.15, 0.3, 0.3}));
  const Certificate c = certify(body.asset, 0, 100);
  ASSERT_FALSE(c.gross.is_passive());
  ASSERT_GT(c.gross.depth_share, 0);
  ASSERT_LT(c.gross.depth_share, 1);
  CertifyOptions options;
  options.continuity.walks = 0;
  options.facet.max_boxes = 100;
  options.facet.depth_share = c.gross.depth_share;
  EXPECT_TRUE(palpate::certify::certify(body.asset, options).gross.is_passive());
  options.facet.depth_share = c.gross.depth_share + 0.1;
  EXPECT_FALSE(palpate::certify::certify(body.asset, options).gross.is_passive());
}

TEST(certificate, a_side_force_beyond_the_normal_one_pulls) {
  for (const double side_N_m2 : {20.0, 2000.0, 60000.0}) {
    Model model = plate_model(0.08, 8, uniform(400, 300, 0.3));
    make_rings(
        model, 1, 0, [](const Vec3&) { return 1.0; },
        [&](const Vec3&) { return Vec3(side_N_m2, 0, 0); });
    const Certificate c = certify(load(model).asset, 0, 20);
    // mu(d) d / lambda 2 g_2 d against f^z = 12 d + 4500 d^2, at d = 1 cm and near 0.
    const double reach_m = (0.285 + 0.16) * 0.01 / 0.71 + 1e-4;
    const bool pulls = 2 * side_N_m2 * 0.01 * reach_m > 12 * 0.01 + 4500 * 1e-4;
    EXPECT_EQ(c.passive_fixed, !pulls) << side_N_m2;
  }
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

TEST(closed_loop, swings_on_a_stiff_wall_with_delay_and_not_on_a_soft_one) {
  const Device device{"d", "", 8.5, 3500, 3e-5, 0.04, 0.075};
  const ServoLoop prompt{1000, 0, 24, 1}, late{1000, 1, 24, 1}, fast{10000, 1, 24, 1};
  EXPECT_EQ(swinging_hands(device, 200, 3, late), 0);
  EXPECT_EQ(swinging_hands(device, 2e4, 3, late), 24);
  int before = 0;
  for (const double stiffness_N_m : {500.0, 1000.0, 2000.0, 4000.0}) {
    const int swinging = swinging_hands(device, stiffness_N_m, 3, late);
    EXPECT_GE(swinging, before) << stiffness_N_m;
    before = swinging;
  }
  EXPECT_LT(swinging_hands(device, 2000, 3, prompt), swinging_hands(device, 2000, 3, late));
  EXPECT_LT(swinging_hands(device, 2000, 3, fast), swinging_hands(device, 2000, 3, late));
}

TEST(closed_loop, swings_by_the_steps_of_an_encoder_that_friction_does_not_hold) {
  Device device{"d", "", 8.5, 0, 3e-5, 0.04, 0.075};
  const ServoLoop fast{10000, 1, 24, 1};
  EXPECT_FALSE(judge(device, 4000, 3).resolution_fits);  // 4000 N/m 15 um = 0.06 N
  EXPECT_EQ(swinging_hands(device, 4000, 3, fast), 24);
  device.resolution_m = 1e-6;
  EXPECT_EQ(swinging_hands(device, 4000, 3, fast), 0);
}

TEST(closed_loop, is_quieted_by_friction_and_not_simulated_without_a_mass) {
  Device device{"d", "", 8.5, 0, 3e-5, 0, 0.075};
  EXPECT_GT(swinging_hands(device, 1000, 3), 6);
  device.friction_N = 0.26;
  EXPECT_EQ(judge(device, 1000, 3).swinging, 0);
  EXPECT_EQ(judge(device, 1000, 3).hands, 24);
  device.mass_kg = 0;
  EXPECT_EQ(judge(device, 1e5, 3).hands, 0);
}

}  // namespace
}  // namespace palpate::certify::test
