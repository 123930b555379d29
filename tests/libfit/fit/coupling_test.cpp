// How tools feel each other, found from what two of them feel (M62).

#include "libfit/fit/contact_effects.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "libfit/core/statistics.hpp"
#include "libfit/runtime/asset/check.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kDepth_m = 0.004, kLength_m = 0.002;

// Two tools at each of these distances: the second presses, then the first, and is dragged.
struct PairsOnAPlate {
  Loaded plate;
  Samples samples;

  PairsOnAPlate() : plate(load(model())) {
    const std::vector<double> distances_m{0.009, 0.012, 0.018, 0.027};
    constexpr int kRows = 6;
    const auto pairs = static_cast<Eigen::Index>(distances_m.size()), rows = 2 * pairs * kRows;
    samples.point_position = Points::Zero(1 + pairs, 3);
    samples.point_normal = Vec3(0, 0, -1).transpose().replicate(1 + pairs, 1);
    samples.deflection = samples.force = samples.torque = Points::Zero(rows, 3);
    samples.force_error = Eigen::VectorXd::Zero(rows);
    for (std::int32_t pair = 0; pair < pairs; ++pair) {
      const double turn = 1.3 * pair, r = distances_m[static_cast<std::size_t>(pair)];
      samples.point_position.row(1 + pair) << r * std::cos(turn), r * std::sin(turn), 0;
      for (int row = 0; row < kRows; ++row) {
        const double first = std::clamp(row - 1, 0, 3) / 3., second = std::min(row + 1, 2) / 2.;
        const auto at = static_cast<Eigen::Index>(samples.point.size());
        samples.deflection.row(at) << 5e-4 * std::max(0, row - 3), 0, -kDepth_m * first;
        samples.deflection.row(at + 1) << 0, 0, -0.8 * kDepth_m * second;
        for (const std::int8_t tool : {0, 1}) {
          samples.point.push_back(tool == 0 ? 0 : 1 + pair);
          samples.experiment.push_back(pair);
          samples.kind.push_back(ExperimentKind::pair);
          samples.step.push_back(row);
          samples.tool.push_back(tool);
          samples.status.push_back(RowStatus::good);
        }
      }
    }
  }
  static Model model() {
    Model out = plate_model(0.08, 16, uniform(400, 300, 0.3));
    make_rings(out, 1, 0, [](const Vec3&) { return 1; });
    return out;
  }
  CouplingResidual residual() const {
    return coupling_residual(plate.asset, samples, kDepth_m, {});
  }
  runtime::CouplingView found() const {
    return identify_coupling(plate.asset, residual(), kLength_m);
  }
  double p95(const runtime::CouplingView& coupling) const {
    const Eigen::VectorXd left = residual()(coupling);
    std::vector<double> errors;
    for (Eigen::Index row = 0; row < samples.rows(); ++row)
      if (samples.force.row(row).norm() > 0) errors.push_back(left.segment<3>(6 * row).norm());
    return quantile(errors, 0.95);
  }
  void feel(const runtime::CouplingView& truth) {
    samples.force = follow(coupled_by(plate.asset, truth), samples, kDepth_m).force_N;
  }
};

TEST(coupling, is_found_from_what_two_tools_feel) {
  PairsOnAPlate pairs;
  runtime::CouplingView truth;
  truth.length_m = kLength_m;
  truth.isotropic_m_N[1] = 1.2e-3, truth.isotropic_m_N[3] = 8e-4;
  truth.tangential_m_N[2] = 6e-4;
  pairs.feel(truth);
  const runtime::CouplingView found = pairs.found();
  EXPECT_GT(pairs.p95({}), 0.02);
  EXPECT_LT(pairs.p95(found), 2e-3);
  for (const double r : {0.009, 0.012, 0.015, 0.018, 0.022, 0.027}) {
    const auto is = runtime::coupling_at(found, r * r), was = runtime::coupling_at(truth, r * r);
    EXPECT_NEAR(is.isotropic, was.isotropic, 0.03 * was.isotropic) << r;
    EXPECT_NEAR(is.tangential, was.tangential, 0.1 * was.tangential + 0.02 * was.isotropic) << r;
  }
}

TEST(coupling, is_not_found_where_tools_do_not_feel_each_other) {
  PairsOnAPlate pairs;
  pairs.feel({});
  EXPECT_FALSE(pairs.found().is_any());
}

}  // namespace
}  // namespace palpate::test
