
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "libfem/elements/elastic_body.hpp"
#include "tests/libfem/elements/remembering_body.hpp"
#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 90210;

Relaxation series(std::initializer_list<std::pair<double, double>> branches) {
  Relaxation out;
  out.share.resize(static_cast<Eigen::Index>(branches.size()));
  out.time_s.resize(out.share.size());
  Eigen::Index k = 0;
  for (const auto& [share, time_s] : branches) {
    out.share[k] = share;
    out.time_s[k++] = time_s;
  }
  return out;
}

TEST(MaterialHistory, force_and_stiffness_of_a_step_are_derivatives_of_its_energy) {
  const QuadraticMesh mesh = small_block();
  const Mat3 F = Vec3(0.95, 1.03, 1.01).asDiagonal();
  const auto state = [&](unsigned seed) {
    return Points(affine(mesh.nodes, F) + random_field(mesh.nodes.rows(), 0.01 * kSize_m, seed));
  };
  for (const examples::Example& example : examples::all()) {
    SCOPED_TRACE(example.name);
    MaterialParameters parameters = example.parameters;
    parameters.relaxation = series({{0.8, 0.1}, {1.7, 2}});
    RememberingBody moving(mesh, parameters);
    moving.go(state(kSeed + 1), 0.3);
    moving.go(state(kSeed + 2), 0.05);
    moving.begin(0.2);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    expect_derivatives(moving.body(), state(kSeed),
                       random_field(mesh.nodes.rows(), kSize_m, kSeed + 3), 1e-7,
                       example.is_kinked_at_rest ? 1e-5 : 1e-6);
  }
}

TEST(MaterialHistory, every_instruction_set_gives_the_same_bits_in_time) {
  const Points u = random_field(small_block().nodes.rows(), 0.02 * kSize_m, kSeed);
  expect_same_bits_on_every_instruction_set(
      {"yeoh", {1.7e3, -0.1e3, 0.04e3, 0.48}, series({{1, 1}})}, u, -0.5 * u, 0.3, 0.7);
}

TEST(MaterialHistory, a_body_that_turns_keeps_its_stress) {
  const QuadraticMesh mesh = small_block();
  const Points u = random_field(mesh.nodes.rows(), 0.03 * kSize_m, kSeed);
  const Mat3 Q = Eigen::AngleAxisd(2.2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Points turned = (mesh.nodes + u) * Q.transpose() - mesh.nodes;
  RememberingBody still(mesh, {"neo-hookean", {10e3, 0.45}, series({{2, 0.5}})}), turning = still;
  for (RememberingBody* moving : {&still, &turning}) moving->go(u, 0.1);
  still.begin(0.3);
  turning.begin(0.3);
  const Points expected = still.force(u) * Q.transpose();
  EXPECT_LE((turning.force(turned) - expected).norm(), 1e-12 * expected.norm()) << "seed " << kSeed;
}

TEST(MaterialHistory, a_step_of_no_end_has_the_bits_of_slow_motion_and_a_jump_the_sum_of_shares) {
  const QuadraticMesh mesh = small_block();
  const Points u = random_field(mesh.nodes.rows(), 0.03 * kSize_m, kSeed);
  Material fast = make_material({"neo-hookean-isochoric", {10e3, 0.45}}, "test");
  fast.constants[1] *= 3.5;  // the shear modulus; constants[0], the bulk modulus, stays
  RememberingBody moving(mesh,
                         {"neo-hookean-isochoric", {10e3, 0.45}, series({{1, 0.1}, {1.5, 2}})});
  const Points before = moving.force(u);
  moving.go(-u, 0.2);
  moving.begin(kForever);
  EXPECT_TRUE(moving.force(u) == before);
  const Mat3 F = Vec3(1.1, 0.9, 1.05).asDiagonal();
  RememberingBody jumping(mesh,
                          {"neo-hookean-isochoric", {10e3, 0.45}, series({{1, 0.1}, {1.5, 2}})});
  jumping.begin(0);
  EXPECT_LE((jumping.stress(F) - fast.law->evaluate(fast.constants, F).P).norm(),
            1e-12 * jumping.stress(F).norm());
}

/// Pulled to a length share by share, free to the side: the engineering stress.
double pull(RememberingBody& moving, double stretch, double dt_s) {
  moving.begin(dt_s);
  const Mat3 F = pulled_to(moving, stretch);
  const double out = moving.stress(F)(0, 0);
  moving.end(affine(small_block().nodes, F));
  return out;
}

constexpr double kYoung = 10e3, kNu = 0.4;
const double kMu = kYoung / (2 * (1 + kNu)), kLambda = kYoung * kNu / ((1 + kNu) * (1 - 2 * kNu));

// E(p) = lambda + 2 mu(p) - lambda^2 / (lambda + mu(p)) with mu(p) = mu (1 + g p tau / (1 + p tau))
// gives a bar two times: that of the shear, and a longer one as its side follows.
struct BarInSmallStrain {
  double g, tau_s;
  double a = kLambda + kMu, other_s = tau_s * (1 + kMu * g / a);

  double at_step(double t) const {
    const double share = 1 - 1 / (1 + kMu * g / a);
    return kLambda + 2 * kMu * (1 + g * std::exp(-t / tau_s)) -
           kLambda * kLambda / a * (1 - share * std::exp(-t / other_s));
  }
  double at_ramp(double t) const {  // strain t: the integral of at_step
    const double share = 1 - 1 / (1 + kMu * g / a);
    return kYoung * t - 2 * kMu * g * tau_s * std::expm1(-t / tau_s) -
           kLambda * kLambda / a * share * other_s * std::expm1(-t / other_s);
  }
};

TEST(MaterialHistory, a_bar_in_small_strain_relaxes_and_ramps_as_its_closed_form) {
  constexpr double kStrain = 1e-5;
  const BarInSmallStrain exact{1.5, 0.4};
  const MaterialParameters material{"neo-hookean", {kYoung, kNu}, series({{1.5, 0.4}})};
  const QuadraticMesh mesh = small_block();
  RememberingBody step(mesh, material);
  EXPECT_NEAR(pull(step, 1 + kStrain, 0) / kStrain / exact.at_step(0), 1, 1e-4);
  double t = 0;
  for (int i = 0; i < 60; ++i) {
    t += 0.02;
    EXPECT_NEAR(pull(step, 1 + kStrain, 0.02) / kStrain / exact.at_step(t), 1, 1e-4) << t;
  }
  RememberingBody ramp(mesh, material);
  for (int i = 1; i <= 60; ++i) {
    const double now = 0.02 * i;
    EXPECT_NEAR(pull(ramp, 1 + kStrain * now, 0.02) / kStrain / exact.at_ramp(now), 1, 1e-4) << now;
  }
}

/// Neo-Hookean W = mu/2 (I1 - 3) - mu ln J + lambda/2 ln^2 J along F(t), integrated by itself: the
/// second Piola-Kirchhoff stress of shape S = mu (1 - C^-1) drives dQ/dt = g dS/dt - Q/tau.
class Integrated {
 public:
  Integrated(double g, double tau_s) : g_(g), tau_s_(tau_s) {}

  static Mat3 shape(const Mat3& F) {
    return kMu * (Mat3::Identity() - (F.transpose() * F).inverse());
  }
  /// P at F, a small step after the last one, with Q then.
  Mat3 stress(const Mat3& F, double dt, Mat3& Q) const {
    const Mat3 S = shape(F);
    Q = ((1 - dt / (2 * tau_s_)) * Q_ + g_ * (S - S_)) / (1 + dt / (2 * tau_s_));  // trapezoid
    const Mat3 g = F.inverse().transpose();
    return F * (S + Q) + kLambda * std::log(F.determinant()) * g;
  }
  void take(const Mat3& F, const Mat3& Q) {
    S_ = shape(F);
    Q_ = Q;
  }

 private:
  double g_, tau_s_;
  Mat3 S_ = Mat3::Zero(), Q_ = Mat3::Zero();
};

// Pulled to 1.5 within a second and then held, the side free at every instant.
double stretch_at(double t) { return 1 + 0.5 * std::sin(std::min(t, 1.0) * M_PI / 2); }

double integrated_bar(double end_s) {
  Integrated bar(1.5, 0.4);
  constexpr int kSteps = 20000;
  double side = 1, out = 0;
  for (int i = 1; i <= kSteps; ++i) {
    Mat3 Q, F = Vec3(stretch_at(end_s * i / kSteps), side, side).asDiagonal();
    for (int newton = 0; newton < 4; ++newton) {
      const auto side_stress = [&](double s) {
        return bar.stress(Vec3(F(0, 0), s, s).asDiagonal(), end_s / kSteps, Q)(1, 1);
      };
      const double h = 1e-6, here = side_stress(side);
      side -= here * 2 * h / (side_stress(side + h) - side_stress(side - h));
    }
    F = Vec3(F(0, 0), side, side).asDiagonal();
    out = bar.stress(F, end_s / kSteps, Q)(0, 0);
    bar.take(F, Q);
  }
  return out;
}

TEST(MaterialHistory, a_bar_in_finite_strain_meets_an_integrated_equation_to_second_order) {
  const QuadraticMesh mesh = small_block();
  for (const double end_s : {0.8, 1.6}) {
    const double exact = integrated_bar(end_s);
    std::vector<double> errors;
    for (const int steps : {8, 16, 32}) {
      RememberingBody moving(mesh, {"neo-hookean", {kYoung, kNu}, series({{1.5, 0.4}})});
      double last = 0;
      for (int i = 1; i <= steps; ++i)
        last = pull(moving, stretch_at(end_s * i / steps), end_s / steps);
      errors.push_back(std::abs(last / exact - 1));
    }
    EXPECT_LT(errors[0], 2e-3) << end_s;
    for (std::size_t i = 1; i < errors.size(); ++i)
      EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), 2, 0.25) << end_s << " " << errors[i];
  }
}

// A force that rises as t^{3/2} in six rows, whatever a step is against the branch's time.
TEST(MaterialHistory, steps_in_time_leave_what_is_stated) {
  const QuadraticMesh mesh = small_block();
  const auto force = [](double t) { return std::pow(t, 1.5); };
  for (double tau_s = 1e-3; tau_s < 100; tau_s *= 1.5) {
    const RememberingBody body(mesh, {"neo-hookean", {kYoung, kNu}, series({{1, tau_s}})});
    const auto advance = [&](double& q, double from_s, double to_s, double steps) {
      for (int i = 0; i < steps; ++i) {
        const double a = from_s + (to_s - from_s) * i / steps;
        const double b = from_s + (to_s - from_s) * (i + 1) / steps;
        const BranchDecay decay = branch_decay((b - a) / tau_s);
        q = decay.kept * q + decay.taken * (force(b) - force(a));
      }
    };
    double q = 0, exact = 0;
    for (int row = 1; row <= 6; ++row) {
      const double from_s = (row - 1) / 6.0, to_s = row / 6.0;
      advance(q, from_s, to_s, body.body().steps_in_time(from_s, to_s));
      advance(exact, from_s, to_s, 2000);
      EXPECT_NEAR((force(to_s) + q) / (force(to_s) + exact), 1, kStepError) << tau_s << " " << row;
    }
  }
}

TEST(MaterialHistory, simple_shear_there_and_back_meets_an_integrated_equation) {
  const auto F_at = [](double t) {
    Mat3 F = Mat3::Identity();
    F(0, 1) = 0.6 * std::sin(2 * M_PI * t);
    return F;
  };
  Integrated exact(2, 0.1);
  const QuadraticMesh mesh = small_block();
  RememberingBody moving(mesh, {"neo-hookean", {kYoung, kNu}, series({{2, 0.1}})});
  constexpr int kSteps = 100, kWithin = 100;
  for (int i = 1; i <= kSteps; ++i) {
    Mat3 P, Q;
    for (int k = 1; k <= kWithin; ++k) {
      const Mat3 F = F_at((i - 1 + double(k) / kWithin) / kSteps);
      P = exact.stress(F, 1.0 / (kSteps * kWithin), Q);
      exact.take(F, Q);
    }
    const Mat3 F = F_at(double(i) / kSteps);
    moving.begin(1.0 / kSteps);
    EXPECT_LE((moving.stress(F) - P).norm(), 2e-3 * 3 * kMu * 0.6) << i;
    moving.end(affine(mesh.nodes, F));
  }
}

}  // namespace
}  // namespace palpate::fem
