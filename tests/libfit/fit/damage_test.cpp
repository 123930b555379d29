// How a body softens, from presses in cycles (docs/method.md, section 26).

#include "libfit/fit/damage.hpp"

#include <gtest/gtest.h>

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

Recorder cycled(const runtime::DamageView& damage, double aside = 0) {
  Recorder rig;
  for (int p = 0; p < 2; ++p) {
    rig.add_point({0, 0, -1});
    const double k = 1e4 * (1 + p), unit_J = k * std::pow(kDeepest_m, 3) / 3;
    std::vector<Vec3> way, force;
    double most_J = 0;
    for (const double share : kShares) {
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
    EXPECT_LT(report.p95, 2e-3);
    EXPECT_GT(report.p95_undamaged, 0.1);
  }
}

TEST(damage, a_body_that_does_not_soften_and_rows_off_the_normal_tell_none) {
  const Recorder whole = cycled({});
  EXPECT_FALSE(fit::identify_damage(parabolas(whole.samples), whole.samples).is_any());
  const Recorder aside = cycled({1.4, 0.05, 0.2, 0}, 0.3);
  fit::DamageReport report;
  EXPECT_FALSE(fit::identify_damage(parabolas(aside.samples), aside.samples, &report).is_any());
  EXPECT_EQ(report.cycles, 0u);
}

}  // namespace
}  // namespace palpate::test
