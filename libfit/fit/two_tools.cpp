#include "libfit/fit/two_tools.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/fit/walk.hpp"
#include "libfit/runtime/series/tick.hpp"

namespace palpate {
namespace {

class TwoTips {
 public:
  TwoTips(const runtime::AssetView& asset, const Vec3& first, const Vec3& second) : asset_(asset) {
    at_[0] = first;
    at_[1] = second;
    tick(first, second);
  }

  void go(const Vec3& first, const Vec3& second) {
    const Vec3 from[2] = {at_[0], at_[1]};
    const double way = std::max((first - from[0]).norm(), (second - from[1]).norm());
    const int steps = ticks_over(way);
    for (int k = 1; k <= steps; ++k) {
      const double share = double(k) / steps;
      tick(from[0] + (first - from[0]) * share, from[1] + (second - from[1]) * share);
    }
  }
  Vec3 force_N(int tool) const { return -Eigen::Map<const Vec3>(tip_[tool].out.force_on_tool_N); }
  std::size_t ticks() const { return ticks_; }

 private:
  void tick(const Vec3& first, const Vec3& second) {
    at_[0] = first;
    at_[1] = second;
    for (int i = 0; i < 2; ++i) {
      tip_[i].contact = &contact_[i];
      tip_[i].tool = i;
      Eigen::Map<Vec3>(tip_[i].place_m) = at_[i];
    }
    touch_together(asset_, together_, tip_, 2, runtime::kMaxTimeStep_s);
    ++ticks_;
  }

  const runtime::AssetView& asset_;
  runtime::Contact contact_[2];
  runtime::TogetherMemory together_;
  runtime::BallTick tip_[2];
  Vec3 at_[2];
  std::size_t ticks_ = 0;
};

// Over the largest force of a row's tool in its experiment.
Eigen::VectorXd largest_forces(const Samples& samples, const Points& force) {
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(samples.rows());
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    for (Eigen::Index other = 0; other < samples.rows(); ++other)
      if (samples.experiment[static_cast<std::size_t>(row)] ==
              samples.experiment[static_cast<std::size_t>(other)] &&
          samples.status[static_cast<std::size_t>(other)] == RowStatus::good)
        largest[row] = std::max(largest[row], force.row(other).norm());
  return largest;
}

}  // namespace

TwoToolForces replay_two_tools(const runtime::AssetView& asset,
                               const runtime::CouplingView& coupling, const Samples& samples,
                               const std::vector<ToolPath>& paths, double depth_m) {
  TwoToolForces out{Points::Zero(samples.rows(), 3), Points::Zero(samples.rows(), 3)};
  runtime::AssetView view = asset;
  view.coupling = coupling.is_any() ? &coupling : nullptr;
  WalkedBody body(view);
  for (Eigen::Index row = 0; row < samples.rows();) {
    const std::int32_t experiment = samples.experiment[static_cast<std::size_t>(row)];
    const ToolPath& path = paths[static_cast<std::size_t>(experiment)];
    const SecondTool& other = *path.second;
    const Vec3 first = samples.point_position.row(path.point),
               normal = samples.point_normal.row(path.point);
    TwoTips tips(body.fresh(), first - kApproachRatio * depth_m * normal,
                 other.position - kApproachRatio * depth_m * other.normal);
    for (; row < samples.rows() && samples.experiment[static_cast<std::size_t>(row)] == experiment;
         ++row) {
      tips.go(first + samples.deflection.row(row).transpose(),
              other.position + samples.second_deflection.row(row).transpose());
      out.first_N.row(row) = tips.force_N(0);
      out.second_N.row(row) = tips.force_N(1);
    }
    out.ticks += tips.ticks();
  }
  return out;
}

// Forces less the reference's, each over the scale of its error.
Eigen::VectorXd two_tool_residual(const Samples& samples, const TwoToolForces& answered) {
  const Eigen::VectorXd first = largest_forces(samples, samples.force),
                        second = largest_forces(samples, samples.second_force);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * samples.rows());
  const auto put = [&](Eigen::Index at, const Vec3& off, double force, double largest) {
    const double scale = std::max(force, kLightRow * largest);
    if (scale > 0) out.segment<3>(at) = off / scale;
  };
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    if (samples.status[static_cast<std::size_t>(row)] != RowStatus::good) continue;
    const Vec3 f = samples.force.row(row), g = samples.second_force.row(row);
    put(6 * row, answered.first_N.row(row).transpose() - f, f.norm(), first[row]);
    put(6 * row + 3, answered.second_N.row(row).transpose() - g, g.norm(), second[row]);
  }
  return out;
}

std::vector<double> two_tool_errors(const Samples& samples, const TwoToolForces& answered) {
  const Eigen::VectorXd residual = two_tool_residual(samples, answered);
  std::vector<double> errors;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    for (int tool = 0; tool < 2; ++tool)
      if (samples.status[static_cast<std::size_t>(row)] == RowStatus::good &&
          (tool == 0 ? samples.force : samples.second_force).row(row).norm() > 0)
        errors.push_back(residual.segment<3>(6 * row + 3 * tool).norm());
  return errors;
}

}  // namespace palpate
