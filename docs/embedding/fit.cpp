// Rows of depth and force to a curve with libfit: fit. The rows are those of a ball of 5 mm on
// silicone, with noise of 2 mN.
#include <cmath>
#include <cstdio>
#include <random>

#include "libfit/core/error.hpp"
#include "libfit/fit/fit_curves.hpp"

int main() try {
  using namespace palpate;
  const Vec3 inward(0, 0, -1);

  // 1. The rows: here a press to 5 mm in 25 steps; a program reads its own. Forces are those on the
  //    body.
  const Eigen::Index rows = 25;
  std::mt19937 random(1);
  std::normal_distribution<double> noise_N(0, 0.002);
  Samples samples;
  samples.deflection.resize(rows, 3);
  samples.force.resize(rows, 3);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double depth_m = 0.0002 * static_cast<double>(row + 1);
    samples.deflection.row(row) = depth_m * inward;
    samples.force.row(row) = (2000 * std::pow(depth_m, 1.5) + noise_N(random)) * inward;
    samples.step.push_back(static_cast<std::int32_t>(row));
  }
  samples.torque = Points::Zero(rows, 3);
  samples.force_error = Eigen::VectorXd::Constant(rows, 0.002);

  // 2. The experiment they belong to: all are of press 0 at point 0.
  samples.point.assign(rows, 0);
  samples.experiment.assign(rows, 0);
  samples.kind.assign(rows, ExperimentKind::press);
  samples.status.assign(rows, RowStatus::good);

  // 3. The place: a point of the surface and its inward normal.
  samples.point_position = Points::Zero(1, 3);
  samples.point_normal = inward.transpose();
  samples.point_name = {"a"};

  // 4. Fit. Curves are splines that never fall, of as few pieces as predict rows left out.
  FitReport report;
  const FittedCurves fitted = fit_curves(samples, {.tolerance = 0.03}, {}, &report);
  if (fitted.status[0] == FitStatus::failed) return 1;

  // 5. The curve as numbers: force at a depth is the sum of its control values times B-splines.
  const CurveBasis& basis = fitted.curves.basis[0];
  std::printf("degree %d, pieces: %d, %s\ncontrol [N]", basis.degree, basis.pieces(),
              report.kind[0].reason.c_str());
  for (const double control : fitted.curves.control[0].row(0)) std::printf(" %.4f", control);
  std::printf("\nresidual %.4f N\n", fitted.rms_residual_N[0]);
  return 0;
} catch (const palpate::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
