#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

Samples some_points(int count) {
  Recorder rig;
  for (int p = 0; p < count; ++p) {
    const int point = rig.add_point(Vec3(0.1 * p, 0.2, -1));
    const double k = 300 + 20 * p;
    const Curve normal = [k](double d) { return k * d * (1 + 40 * d); };
    const Curve lateral = [k](double r) { return 0.7 * k * r; };
    const Curve limit = [k](double d) { return 0.35 * k * d; };
    rig.press(point, normal, 0.01, 12);
    for (const double depth_m : {0.004, 0.008})
      rig.flat_drag(point, normal, lateral, limit, depth_m, 0.012, 14, 0.3);
  }
  return rig.samples;
}

TEST(WarmStart, keeps_the_bases_and_brings_what_a_whole_fit_does) {
  Samples samples = some_points(5);
  const FittedCurves first = fit_curves(samples, kSeparable);
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    if (samples.point[static_cast<std::size_t>(i)] == 3) samples.force.row(i) *= 1.2;
  FitOptions options = kSeparable;
  options.warm_start = &first;
  const FittedCurves warm = fit_curves(samples, options), whole = fit_curves(samples, kSeparable);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    EXPECT_EQ(warm.curves.basis[kind].knots_m, first.curves.basis[kind].knots_m);
    EXPECT_EQ(warm.curves.control[kind], whole.curves.control[kind]) << kCurveNames[kind];
    EXPECT_NE(warm.curves.control[kind].row(3), first.curves.control[kind].row(3));
  }
  EXPECT_EQ(warm.rms_residual_N, whole.rms_residual_N);
}

}  // namespace
}  // namespace palpate::test
