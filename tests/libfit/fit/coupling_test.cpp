// How tools feel each other, found from what two of them feel (M62).

#include "libfit/fit/coupling.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "libfit/core/statistics.hpp"
#include "libfit/fit/two_tools.hpp"
#include "libfit/runtime/asset/check_blocks.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kDepth_m = 0.004, kLength_m = 0.002;

// Two tools at each of these distances: the second presses, then the first, and is dragged.
struct PairsOnAPlate {
  Loaded plate;
  Samples samples;
  std::vector<ToolPath> paths;

  PairsOnAPlate() : plate(load(model())) {
    const std::vector<double> distances_m{0.009, 0.012, 0.018, 0.027};
    constexpr int kRows = 6;
    const auto rows = static_cast<Eigen::Index>(distances_m.size()) * kRows;
    samples.point_position = Vec3(0, 0, 0).transpose();
    samples.point_normal = Vec3(0, 0, -1).transpose();
    samples.deflection = samples.second_deflection = Points::Zero(rows, 3);
    samples.force = samples.second_force = Points::Zero(rows, 3);
    for (std::size_t pair = 0; pair < distances_m.size(); ++pair) {
      const double turn = 1.3 * static_cast<double>(pair), r = distances_m[pair];
      ToolPath path;
      path.second = SecondTool{Vec3(r * std::cos(turn), r * std::sin(turn), 0), Vec3(0, 0, -1), {}};
      path.deflections = path.second->deflections = Points::Zero(kRows, 3);
      for (int row = 0; row < kRows; ++row) {
        const double first = std::clamp(row - 1, 0, 3) / 3., second = std::min(row + 1, 2) / 2.;
        path.deflections.row(row) << 5e-4 * std::max(0, row - 3), 0, -kDepth_m * first;
        path.second->deflections.row(row) << 0, 0, -0.8 * kDepth_m * second;
        const auto at = static_cast<Eigen::Index>(pair) * kRows + row;
        samples.deflection.row(at) = path.deflections.row(row);
        samples.second_deflection.row(at) = path.second->deflections.row(row);
        samples.point.push_back(0);
        samples.experiment.push_back(static_cast<std::int32_t>(pair));
        samples.status.push_back(RowStatus::good);
      }
      paths.push_back(path);
    }
  }
  static Model model() {
    Model out = plate_model(0.08, 16, uniform(400, 300, 0.3));
    make_rings(out, 1, 0, [](const Vec3&) { return 1; });
    return out;
  }
  runtime::CouplingView found(double* scaled = nullptr) const {
    return identify_coupling(
        plate.asset,
        [&](const runtime::CouplingView& coupling) {
          return two_tool_residual(samples, forces(coupling));
        },
        kLength_m, scaled);
  }
  TwoToolForces forces(const runtime::CouplingView& coupling) const {
    return replay_two_tools(plate.asset, coupling, samples, paths, kDepth_m);
  }
  double p95(const runtime::CouplingView& coupling) const {
    return quantile(two_tool_errors(samples, forces(coupling)), 0.95);
  }
  void feel(const runtime::CouplingView& truth) {
    const TwoToolForces felt = forces(truth);
    samples.force = felt.first_N;
    samples.second_force = felt.second_N;
  }
};

TEST(coupling, is_found_from_what_two_tools_feel) {
  PairsOnAPlate pairs;
  runtime::CouplingView truth;
  truth.length_m = kLength_m;
  truth.give_m_N[1] = 1.2e-3, truth.give_m_N[3] = 8e-4;
  truth.across_m_N[2] = 6e-4;
  ASSERT_LT(runtime::coupling_excess(pairs.plate.asset, truth), 1);
  pairs.feel(truth);
  double scaled = 0;
  const runtime::CouplingView found = pairs.found(&scaled);
  EXPECT_EQ(scaled, 1);
  EXPECT_GT(pairs.p95({}), 0.02);
  EXPECT_LT(pairs.p95(found), 2e-3);
  for (const double r : {0.009, 0.012, 0.015, 0.018, 0.022, 0.027}) {
    const auto is = runtime::coupling_at(found, r * r), was = runtime::coupling_at(truth, r * r);
    EXPECT_NEAR(is.give, was.give, 0.03 * was.give) << r;
    EXPECT_NEAR(is.across, was.across, 0.1 * was.across + 0.02 * was.give) << r;
  }
}

TEST(coupling, is_not_found_where_tools_do_not_feel_each_other) {
  PairsOnAPlate pairs;
  pairs.feel({});
  EXPECT_FALSE(pairs.found().is_any());
}

}  // namespace
}  // namespace palpate::test
