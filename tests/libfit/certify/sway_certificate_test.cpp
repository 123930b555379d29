// A certificate of a body that sways holds against attack, with the guard off.

#include <gtest/gtest.h>

#include "tests/libfit/certify/attack.hpp"

namespace palpate::certify::test {
namespace {

using Mat3 = Eigen::Matrix3d;

// Compliances of 0.2 to 5 mm/N along axes of their own, which wave over the body by up to
// `unevenness`.
void sway_by(Model& model, unsigned seed, double unevenness) {
  std::mt19937 random(seed + 1000);
  std::uniform_real_distribution<double> unit(0, 1);
  const Mat3 axes =
      Eigen::Quaterniond(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5, unit(random))
          .normalized()
          .toRotationMatrix();
  Vec3 give;
  for (double& c : give) c = 5e-3 * std::pow(25, -unit(random));
  const Mat3 C = axes * give.asDiagonal() * axes.transpose();
  const auto wave = waves(seed + 1000);
  auto& sway = model.curves.control[runtime::kSway];
  for (Eigen::Index v = 0; v < sway.rows(); ++v) {
    const double scale = 1 + unevenness * wave(model.surface.vertices.row(v));
    sway.row(v) << C(0, 0), C(1, 1), C(2, 2), C(0, 1), C(0, 2), C(1, 2);
    sway.row(v) *= std::max(scale, 0.1);
  }
  sway = rounded_to_float(sway);
}
Model swaying_body(unsigned seed) {
  Model model = random_body(seed, random_kind(seed));
  sway_by(model, seed, seed % 4 < 2 ? 0.3 : 0.05);
  return model;
}

TEST(sway_certificate, no_slip_from_any_state_of_the_rings_creates_energy_where_it_is_certified) {
  const Attack sum = attack(OtherRings::any, swaying_body);
  EXPECT_GT(sum.slips, 3000);
  EXPECT_GT(sum.created, 100) << "too weak to find what is not certified";
  EXPECT_LT(sum.faster, sum.slips);
}
TEST(sway_certificate, no_gross_slip_creates_energy_where_it_is_certified) {
  const Attack sum = attack(OtherRings::sliding, swaying_body);
  EXPECT_GT(sum.slips, 10000);
  EXPECT_GT(sum.created, 100) << "too weak to find what is not certified";
}

// An even plate whose sway alone changes: under a force f a slip towards where it gives less
// stores 1/2 f.dC f more, and friction pays mu c_1 d.
TEST(sway_certificate, asks_for_the_friction_that_pays_for_a_sway_that_falls_along_the_slide) {
  for (const double slope_per_N : {0.05, 0.2, 0.8}) {
    Model model = plate_model(0.08, 8, uniform(400, 300, 0.3));
    make_rings(model, 1, 0, [](const Vec3&) { return 1.0; });
    auto& sway = model.curves.control[runtime::kSway];
    for (Eigen::Index v = 0; v < sway.rows(); ++v)
      sway(v, 2) = 0.05 + slope_per_N * model.surface.vertices(v, 0);
    sway = rounded_to_float(sway);
    const Loaded body = load(model);
    FacetOptions options;
    options.far = 0;
    double bound = 0, found = 0;
    for (int t = 0; t < body.asset.triangles; ++t) {
      if (zone_of(body.asset, t) != Zone::interior) continue;
      const Sliding sliding = certify_sliding(body.asset, t, OtherRings::sliding, options);
      bound = std::max(bound, sliding.ratio);
      found = std::max(found, sliding.worst_found);
    }
    // f^z = 12 d + 4500 d^2 at 1 cm along z, which is the normal; all rings pay mu sum c_i h_i.
    const double normal_N = 0.57, mu = 0.285 + 0.16,
                 ratio = 0.5 * slope_per_N * normal_N * normal_N / (mu * normal_N);
    EXPECT_NEAR(found, ratio, 0.02 * ratio) << slope_per_N;
    EXPECT_GE(bound, found) << slope_per_N;
    EXPECT_LT(bound, 1.2 * ratio) << slope_per_N;
  }
}

// Random legs over swaying plates, each tick's exact work, the guard off.
TEST(sway_certificate, no_walk_over_a_certified_body_creates_energy_at_any_tick) {
  long slips = 0;
  int bodies = 0;
  for (unsigned seed = 2; seed <= 16; seed += 2) {
    Model model = random_body(seed, {1, 0.04, 1});
    sway_by(model, seed, 0.02);
    const Loaded body = load(model);
    const Certificate certificate = certify(body.asset, 0, 200);
    if (!certificate.certified()) continue;
    ++bodies;
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    double moved_J = 0, stored_J = 0;
    walk(bare, seed, 60, 0.012, [&](const Output& out, double lost_J, int leg) {
      moved_J += std::abs(out.stored_J + lost_J - stored_J);
      stored_J = out.stored_J;
      slips += out.state == ContactState::slip;
      EXPECT_GE(lost_J, -1e-11 * moved_J) << "seed " << seed << ", leg " << leg;
    });
  }
  EXPECT_GE(bodies, 4);
  EXPECT_GT(slips, 8000);
}

}  // namespace
}  // namespace palpate::certify::test
