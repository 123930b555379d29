#include <gtest/gtest.h>

#include "tests/libfit/fit/case_files.hpp"
#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

TEST(reference, friction_falling_with_depth_comes_from_noisy_slip_rows) {
  PALPATE_NEEDS_DATA("cases/curves");
  const auto pairs = number_rows(kCaseCurves / "mu_slip_pairs.csv");
  const Curve mu = through(number_rows(kCaseCurves / "mu_TRUTH.csv"));
  Recorder rig;
  const int p = rig.add_point(Vec3(1, 1, 0));
  const Vec3 u = rig.inward(p), t = rig.tangent(p, 0);
  double deepest_m = 0;
  for (const auto& pair : pairs) {  // stick for 1 mm per 0.1 N, then the recorded slip force
    const double depth_m = pair[0] * 1e-3, hold_m = pair[2] * 1e-2;
    std::vector<Vec3> deflection, force;
    for (const double share : {0.3, 0.6, 0.9, 1.5, 2.0}) {
      deflection.push_back(depth_m * u + share * hold_m * t);
      force.push_back(pair[1] * u + std::min(share, 1.0) * pair[2] * t);
    }
    rig.add(p, ExperimentKind::drag, deflection, force, 0.02 * pair[2]);
    deepest_m = std::max(deepest_m, depth_m);
  }
  const FittedCurves fitted =
      fit_curves(rig.samples, {.family = CurveFamily::separable, .tolerance = 0});
  const Curve limit = fitted_curve(fitted, 0, CurveKind::limit);
  const Curve normal = fitted_curve(fitted, 0, CurveKind::normal);
  const Curve found = [&](double d) { return limit(d) / normal(d); };
  const double error = relative_rmse(found, mu, deepest_m);
  RecordProperty("relative_rmse", std::to_string(error));
  // Least squares that knows the rational form of mu reaches 0.3 %; free curves pay below the
  // shallowest row (0.22 mm), where both L and f^z vanish.
  EXPECT_LT(error, 0.02);
  for (double d = 0.1 * deepest_m; d < deepest_m; d += 1e-4)
    EXPECT_NEAR(found(d), mu(d), 0.015 * mu(d)) << "depth " << d;
}

}  // namespace
}  // namespace palpate::test
