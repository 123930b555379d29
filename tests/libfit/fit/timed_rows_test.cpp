// Curves of slow motion from rows that have times (docs/method-body.md, section 24).

#include <gtest/gtest.h>

#include "libfit/core/error.hpp"
#include "tests/libfit/fit/ring_truth.hpp"

namespace palpate::test {
namespace {

// Presses at two speeds, one held and one that turns back, of a body that relaxes by more than it
// bears in slow motion: the curves are those of slow motion.
TEST(timed_rows, have_the_curves_of_slow_motion) {
  const Vec3 inward(0, 0, -1);
  RingTruth truth(inward, Mat3::Zero(), 4);
  truth.control[4] = truth.control[5] = {0, 0, 0};
  Recorder rig;
  const int p = rig.add_point(inward, Mat3::Zero());
  rig.samples.relaxation.share = Eigen::Vector2d(0.7, 0.9);
  rig.samples.relaxation.time_s = Eigen::Vector2d(0.08, 1.5);
  std::vector<double> time_s;
  for (const double duration_s : {0.1, 3.0}) {
    std::vector<Vec3> rows;
    std::vector<double> when;
    for (int i = 1; i <= 24; ++i) {
      rows.push_back(kDepth_m * i / 24 * inward);
      when.push_back(duration_s * i / 24);
    }
    for (int i = 1; i <= 10; ++i) {
      rows.push_back((duration_s > 1 ? 1 - 0.05 * i : 1) * kDepth_m * inward);
      when.push_back(duration_s + 0.2 * i);
    }
    std::vector<CurveBasis> all(parts_of(CurveFamily::rings).size());
    all[0] = truth.basis;
    const fit::Bases bases(all, CurveFamily::rings, rig.samples.relaxation);
    std::vector<runtime::Vec3d> force(rows.size());
    runtime::replay_drag<double>(
        bases.views, fit::pointers_to<double>(truth.control), fit::quadric_of(inward, Mat3::Zero()),
        {rows.front().data(), static_cast<int>(rows.size()), when.data()}, nullptr, force.data());
    std::vector<Vec3> forces;
    for (const auto& f : force) forces.emplace_back(f.x, f.y, f.z);
    rig.add(p, ExperimentKind::press, rows, forces);
    time_s.insert(time_s.end(), when.begin(), when.end());
  }
  FitOptions options;
  options.knots_m[0] = truth.basis.knots_m;
  const auto worst = [&](const Samples& samples) {
    const FittedCurves fitted = fit_curves(samples, options);
    const fit::Bases exact = truth.bases(), own = fit::bases_of(fitted.curves);
    const Eigen::VectorXd control = fitted.curves.control[0].row(0);
    double out = 0;
    for (double d = 0.1 * kDepth_m; d < kDepth_m; d += 0.05 * kDepth_m) {
      const double f = runtime::curve_value(own.views.view[0], control.data(), d),
                   g = runtime::curve_value(exact.views.view[0], truth.control[0].data(), d);
      out = std::max(out, std::abs(f / g - 1));
    }
    return out;
  };
  EXPECT_GT(worst(rig.samples), 0.5) << "without times";
  rig.samples.time_s =
      Eigen::VectorXd::Map(time_s.data(), static_cast<Eigen::Index>(time_s.size()));
  EXPECT_LT(worst(rig.samples), 0.01);
  options.family = CurveFamily::separable;
  EXPECT_THROW(fit_curves(rig.samples, options), Error);
}

}  // namespace
}  // namespace palpate::test
