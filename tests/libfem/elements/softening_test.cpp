#include "libfem/materials/softening.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "libfem/elements/elastic_body.hpp"
#include "tests/libfem/elements/remembering_body.hpp"
#include "tests/libfem/materials/examples.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 1999;
constexpr Softening kSoftening{1.4, 300, 0.2};

MaterialParameters softening(MaterialParameters material) {
  material.softening = kSoftening;
  return material;
}

/// A body that softens, always at the beginning of a step.
class Cycled : public RememberingBody {
 public:
  Cycled(const QuadraticMesh& mesh, const MaterialParameters& material)
      : RememberingBody(mesh, material) {
    begin(kForever);
  }
  void go(const Points& u) {
    end(u);
    begin(kForever);
  }
};

// eta of Ogden and Roxburgh.
double factor(double W, double most) {
  return W < most ? 1 - std::erf((most - W) / (kSoftening.scale_Pa + kSoftening.beta * most)) /
                            kSoftening.r
                  : 1;
}

TEST(softening, the_error_function_and_its_integral_are_right_to_the_last_digits) {
  for (double x = 0; x < 30; x += 0.0137) {
    double erf, integral;
    erf_of(x, erf, integral);
    const double exact = x * std::erf(x) + std::expm1(-x * x) / std::sqrt(M_PI);
    EXPECT_NEAR(erf, std::erf(x), 2e-15) << x;
    EXPECT_NEAR(integral, exact, 2e-15 * (1 + exact)) << x;
  }
}

TEST(softening, force_and_stiffness_are_derivatives_of_the_energy_below_and_above_the_peak) {
  const QuadraticMesh mesh = small_block();
  const auto state = [&](double stretch, unsigned seed) {
    const Mat3 F = Vec3(stretch, 1 / std::sqrt(stretch), 1.01).asDiagonal();
    return Points(affine(mesh.nodes, F) + random_field(mesh.nodes.rows(), 0.01 * kSize_m, seed));
  };
  for (const examples::Example& example : examples::all()) {
    for (const double stretch : {1.1, 1.4}) {
      SCOPED_TRACE(example.name + " to " + std::to_string(stretch));
      Cycled moving(mesh, softening(example.parameters));
      moving.go(state(1.25, kSeed + 1));
      SCOPED_TRACE("seed " + std::to_string(kSeed));
      expect_derivatives(moving.body(), state(stretch, kSeed),
                         random_field(mesh.nodes.rows(), kSize_m, kSeed + 3), 1e-6,
                         example.is_kinked_at_rest ? 1e-5 : 2e-6);
    }
  }
}

TEST(softening, a_rubber_pulled_let_go_and_pulled_again_has_the_stress_of_ogden_and_roxburgh) {
  constexpr double kYoung = 3e3, kMu = kYoung / 3;  // incompressible all but 1e-4
  const QuadraticMesh mesh = small_block();
  Cycled moving(mesh, softening({"neo-hookean-isochoric", {kYoung, 0.49999}}));
  double most = 0;
  for (const double stretch : {1.2, 1.5, 1.8, 1.5, 1.2, 1.0, 1.3, 1.8, 2.2, 1.4}) {
    const Mat3 F = pulled_to(moving, stretch);
    const double energy = kMu / 2 * (stretch * stretch + 2 / stretch - 3);
    most = std::max(most, energy);
    const double exact = factor(energy, most) * kMu * (stretch - 1 / (stretch * stretch));
    EXPECT_NEAR(moving.stress(F)(0, 0), exact, 3e-4 * kMu) << stretch;
    moving.go(affine(mesh.nodes, F));
  }
}

TEST(softening, a_body_that_was_never_unloaded_has_the_bits_of_one_that_does_not_soften) {
  const QuadraticMesh mesh = small_block();
  for (const examples::Example& example : examples::all()) {
    SCOPED_TRACE(example.name);
    const ElasticBody plain(mesh, {make_material(example.parameters, "test")}, nullptr);
    Cycled moving(mesh, softening(example.parameters));
    for (const double stretch : {1.02, 1.05, 1.1, 1.2}) {
      const Points u =
          affine(mesh.nodes, Mat3(Vec3(stretch, 1 / std::sqrt(stretch), 1).asDiagonal()));
      Points force = Points::Zero(u.rows(), 3);
      plain.add_force(u, force);
      EXPECT_TRUE(moving.force(u) == force) << stretch;
      moving.go(u);
    }
  }
}

TEST(softening, every_instruction_set_gives_the_same_bits) {
  const Points u = random_field(small_block().nodes.rows(), 0.02 * kSize_m, kSeed);
  expect_same_bits_on_every_instruction_set(softening({"yeoh", {1.7e3, -0.1e3, 0.04e3, 0.48}}), u,
                                            -1.5 * u, kForever, kForever);
}

TEST(softening, what_a_material_cannot_soften_is_refused) {
  const auto refusal_of = [](MaterialParameters material, Softening softening) {
    material.softening = softening;
    return testing_support::error_of([&] { make_material(material, "[material]"); });
  };
  const MaterialParameters rubber{"neo-hookean", {3e3, 0.45}};
  EXPECT_EQ(refusal_of(rubber, {1, 0, 0.1}), "accepted");
  EXPECT_NE(refusal_of(rubber, {0.9, 0, 0.1}).find("r from 1"), std::string::npos);
  EXPECT_NE(refusal_of(rubber, {1.5, 0, 0}).find("not both 0"), std::string::npos);
  MaterialParameters slow = rubber;
  slow.relaxation.share = slow.relaxation.time_s = Eigen::VectorXd::Constant(1, 0.5);
  EXPECT_NE(refusal_of(slow, kSoftening).find("relaxes"), std::string::npos);
}

}  // namespace
}  // namespace palpate::fem
