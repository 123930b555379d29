// How a body softens, from presses in cycles (docs/method-body.md, section 26).

#include "libfit/fit/contact_effects.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

constexpr double kDeepest_m = 0.01;
constexpr std::array kShares{0.25, 0.5, 0.35, 0.2, 0.1, 0.3, 0.5,
                             0.8,  1.0, 0.8,  0.5, 0.2, 0.6, 1.0};

// f = k d^2 at two points, one twice as stiff.
double force_N(double stiffness, double depth_m) { return stiffness * depth_m * depth_m; }

FittedCurves parabolas(const Samples& samples) {
  FittedCurves out;
  out.position = samples.point_position;
  out.normal = samples.point_normal;
  out.name = samples.point_name;
  out.status.assign(2, FitStatus::good);
  for (std::size_t k = 0; k < kCurveKinds; ++k) {
    out.curves.basis[k] = {2, {0, kDeepest_m}};
    out.curves.control[k] = Controls::Zero(2, 3);
  }
  for (int p = 0; p < 2; ++p) {
    const double end_N = force_N(1e4 * (1 + p), kDeepest_m);  // Bernstein's: 0, 0, the end
    out.curves.control[0].row(p) << 0, 0, end_N;
    out.curves.control[1].row(p) << 0, end_N / 2, end_N;
    out.curves.control[2].row(p) << 0, end_N / 2, end_N;
  }
  return out;
}

const std::vector<double> kFew(kShares.begin(), kShares.end());

// As a rig records them: by hundredths of the depth.
std::vector<double> many() {
  std::vector<double> out;
  double at = 0;
  for (const double turn : {0.5, 0.05, 1.0, 0.05, 1.0})
    for (const double step = turn > at ? 0.01 : -0.01; std::abs(turn - at) > 0.005;)
      out.push_back(at += step);
  return out;
}

Recorder cycled(const runtime::DamageView& damage, double aside = 0,
                const std::vector<double>& shares = kFew) {
  Recorder rig;
  for (int p = 0; p < 2; ++p) {
    rig.add_point({0, 0, -1});
    const double k = 1e4 * (1 + p), unit_J = k * std::pow(kDeepest_m, 3) / 3;
    std::vector<Vec3> way, force;
    double most_J = 0;
    for (const double share : shares) {
      const double d = share * kDeepest_m, law_J = k * d * d * d / 3;
      most_J = std::max(most_J, law_J);
      way.emplace_back(aside * d, 0, -d);
      force.emplace_back(0, 0,
                         -force_N(k, d) * runtime::softened(damage, unit_J, most_J, law_J).share);
    }
    rig.add(p, ExperimentKind::path, way, force);
  }
  return rig;
}

TEST(damage, its_numbers_are_found_again_in_presses_in_cycles) {
  for (const runtime::DamageView& truth :
       {runtime::DamageView{1.4, 0.05, 0.2, 0}, runtime::DamageView{3, 0.01, 0.6, 0},
        runtime::DamageView{1.05, 0.02, 0.4, 0}}) {
    Recorder rig = cycled(truth);
    rig.samples.probe = sphere_spec(0.005);
    fit::DamageReport report;
    const auto found = fit::identify_damage(parabolas(rig.samples), rig.samples, &report);
    SCOPED_TRACE(truth.r);
    EXPECT_NEAR(found.r, truth.r, 0.01 * truth.r);
    EXPECT_NEAR(found.scale, truth.scale, 0.02 * truth.scale + 1e-3);
    EXPECT_NEAR(found.beta, truth.beta, 0.02 * truth.beta);
    EXPECT_GT(found.reach_m, 0);
    EXPECT_EQ(report.cycles, 2u);
    EXPECT_EQ(report.rows, 2 * kShares.size());
    EXPECT_LT(report.damaged.p95, 2e-3);
    EXPECT_GT(report.undamaged.p95, 0.1);
  }
}

// Forces with noise of 0.5 % of the largest, many times over: numbers stay within what the fit says
// of them.
TEST(damage, with_noise_its_numbers_are_within_the_deviations_that_are_stated) {
  for (const runtime::DamageView& truth :
       {runtime::DamageView{1.4, 0.05, 0.2, 0}, runtime::DamageView{2, 0.02, 0.4, 0}}) {
    SCOPED_TRACE(truth.r);
    const Samples clean = cycled(truth, 0, many()).samples;
    std::mt19937 random(11);
    std::normal_distribution<double> noise(0, 5e-3);
    double squares = 0;
    int count = 0;
    for (int draw = 0; draw < 20; ++draw) {
      Samples samples = clean;
      for (Eigen::Index i = 0; i < samples.rows(); ++i)
        samples.force(i, 2) += noise(random) * (samples.point[static_cast<std::size_t>(i)] + 1);
      fit::DamageReport report;
      const auto found = fit::identify_damage(parabolas(samples), samples, &report);
      const std::array off{std::log(found.r / truth.r), std::log(found.scale / truth.scale),
                           std::log(found.beta / truth.beta)};
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_LT(std::abs(off[k]), 5 * report.deviation[k])
            << "seed 11, draw " << draw << " number " << k;
        squares += std::pow(off[k] / report.deviation[k], 2);
        ++count;
      }
    }
    EXPECT_GT(squares / count, 0.5) << "deviations are not too large";
    EXPECT_LT(squares / count, 2) << "or too small";
  }
}

TEST(damage, a_body_that_does_not_soften_and_rows_off_the_normal_tell_none) {
  const Recorder whole = cycled({});
  EXPECT_FALSE(fit::identify_damage(parabolas(whole.samples), whole.samples).softens());
  const Recorder aside = cycled({1.4, 0.05, 0.2, 0}, 0.3);
  fit::DamageReport report;
  EXPECT_FALSE(fit::identify_damage(parabolas(aside.samples), aside.samples, &report).softens());
  EXPECT_EQ(report.cycles, 0u);
}

}  // namespace
}  // namespace palpate::test
