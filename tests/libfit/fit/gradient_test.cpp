#include <ceres/ceres.h>
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

fit::PointExperiment experiment_of(const std::vector<Vec3>& rows) {
  fit::PointExperiment e;
  e.deflection = rows;
  e.force.assign(rows.size(), Vec3(0.1, -0.05, 0.6));
  e.weight.assign(rows.size(), 2.0);
  e.row.resize(rows.size());
  return e;
}

// Largest entry of a drag's Jacobian that Ceres' GradientChecker contradicts, over the Jacobian's
// largest: entry by entry relative errors mean nothing where the truth is 0. Units of order 1.
double contradicted(const fit::ReplayResidual& residual, std::size_t rows,
                    const Eigen::VectorXd& x) {
  ceres::DynamicAutoDiffCostFunction<fit::ReplayResidual, 8> cost(
      new fit::ReplayResidual(residual));
  cost.AddParameterBlock(static_cast<int>(x.size()));
  cost.SetNumResiduals(static_cast<int>(3 * rows));
  ceres::NumericDiffOptions numeric;
  numeric.ridders_relative_initial_step_size = 1e-6;  // first step 32 times that: no kink within
  const std::vector<const ceres::Manifold*>* none = nullptr;
  const ceres::GradientChecker checker(&cost, none, numeric);
  const double* block = x.data();
  ceres::GradientChecker::ProbeResults results;
  checker.Probe(&block, 1e-6, &results);
  return (results.jacobians[0] - results.numeric_jacobians[0]).cwiseAbs().maxCoeff() /
         results.numeric_jacobians[0].cwiseAbs().maxCoeff();
}

double gradient_error(const std::vector<Vec3>& rows, const Mat3& gradient,
                      const std::array<Eigen::VectorXd, kCurveKinds>& increments,
                      double loss_scale = fit::ReplayResidual::kNoOutliers) {
  const fit::Bases bases(
      {CurveBasis{3, {0, 0.5, 1}}, CurveBasis{3, {0, 0.3, 0.6}}, CurveBasis{3, {0, 1}}});
  const fit::PointExperiment e = experiment_of(rows);
  Eigen::VectorXd x(increments[0].size() + increments[1].size() + increments[2].size());
  x << increments[0], increments[1], increments[2];
  return contradicted({&bases,
                       fit::quadric_of(Vec3::UnitZ(), gradient),
                       &e,
                       {true, true, true},
                       increments,
                       loss_scale},
                      rows.size(), x);
}

std::array<Eigen::VectorXd, kCurveKinds> random_increments(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0.5, 1.5);
  std::array<Eigen::VectorXd, kCurveKinds> out{Eigen::VectorXd(4), Eigen::VectorXd(4),
                                               Eigen::VectorXd(3)};
  const std::array<double, kCurveKinds> scale{0.25, 0.15, 0.12};
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    for (double& a : out[kind]) a = scale[kind] * draw(random);
  return out;
}

TEST(gradient, of_a_replayed_drag_is_its_derivative_stuck_slipping_and_curved) {
  const Vec3 u = Vec3::UnitZ(), t = Vec3(0.8, 0.6, 0);
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Mat3 sphere = Mat3::Zero();
    sphere(0, 0) = sphere(1, 1) = seed % 2 == 0 ? -0.2 : 0;
    for (const double loss_scale : {fit::ReplayResidual::kNoOutliers, 0.1})
      for (const double depth : {0.2, 0.5, 0.9})
        EXPECT_LT(gradient_error(drag_rows(u, t, depth, 0.8, 9), sphere, random_increments(seed),
                                 loss_scale),
                  1e-7)
            << "seed " << seed << " depth " << depth;
  }
}

TEST(gradient, holds_on_both_sides_of_the_transition_from_stick_to_slip) {
  const auto increments = random_increments(3);
  const fit::Bases bases(
      {CurveBasis{3, {0, 0.5, 1}}, CurveBasis{3, {0, 0.3, 0.6}}, CurveBasis{3, {0, 1}}});
  const Eigen::VectorXd lateral = fit::controls_of(increments[1]);
  const Eigen::VectorXd limit = fit::controls_of(increments[2]);
  const double depth = 0.6;
  const double hold = runtime::curve_value(bases.views.view[2], limit.data(), depth);
  double lo = 0, hi = 2;  // where f^r reaches L
  for (int i = 0; i < 60; ++i) {
    const double middle = (lo + hi) / 2;
    (runtime::curve_value(bases.views.view[1], lateral.data(), middle) < hold ? lo : hi) = middle;
  }
  for (const double off : {-1e-2, -1e-3, 1e-3, 1e-2}) {
    const std::vector<Vec3> rows{Vec3(0, 0, depth), Vec3((1 + off) * lo, 0, depth)};
    EXPECT_LT(gradient_error(rows, Mat3::Zero(), increments), 1e-7) << "off " << off;
  }
}

TEST(gradient, of_rings_is_the_derivative_of_a_replay_that_sticks_slips_and_turns) {
  const Vec3 u = Vec3::UnitZ(), t = Vec3(0.8, 0.6, 0);
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Mat3 gradient = Mat3::Zero();
    gradient(0, 0) = gradient(1, 1) = seed % 2 == 0 ? -0.2 : 0;
    std::vector<CurveBasis> basis(parts_of(CurveFamily::rings).size());
    basis[0] = {3, {0, 0.5, 1}};
    const fit::Bases bases(basis, CurveFamily::rings);
    const fit::PointExperiment e = experiment_of(there_and_back(u, t, 0.7, 0.8));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> draw(0.8, 1.2);
    Eigen::VectorXd x(12);
    for (int j = 0; j < 4; ++j) x[j] = 0.1 * (j + 1) * draw(random);
    x.tail<8>() << 0.7 * draw(random), 0.3 * draw(random), 0.15 * draw(random), 0.2 * draw(random),
        draw(random) - 1, draw(random) - 1, draw(random) - 1, draw(random) - 1;
    const fit::ReplayResidual residual{&bases,
                                       fit::quadric_of(u, gradient),
                                       &e,
                                       {true, false, false},
                                       {x.head<4>(), {}, {}},
                                       fit::ReplayResidual::kNoOutliers};
    EXPECT_LT(contradicted(residual, e.row.size(), x), 1e-6) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate::test
