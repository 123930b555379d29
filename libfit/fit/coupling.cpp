#include "libfit/fit/coupling.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "libfit/core/statistics.hpp"
#include "libfit/runtime/tool/several_tools.hpp"

namespace palpate {
namespace {

constexpr double kTick_m = 20e-6;
constexpr double kApproachRatio = 0.1;
constexpr double kLightForce = 0.1;  // of the largest: errors of lighter rows are over this
constexpr int kUnknowns = 2 * runtime::kCouplingScales;
constexpr int kMaxSteps = 12, kMaxHalvings = 6;
constexpr double kProbed = 0.02;  // of that limit: a derivative by differences
constexpr double kRidge = 1e-6;   // of the largest entry of the Gram matrix
constexpr double kLimitSpring = 1e3;
constexpr double kLimit = 0.99;  // of what coupling may be
constexpr double kWorth = 0.9;

using Unknowns = Eigen::Vector<double, kUnknowns>;

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
    const int steps = std::max(1, static_cast<int>(std::ceil(way / kTick_m)));
    for (int k = 1; k <= steps; ++k) {
      const double share = double(k) / steps;
      tick(from[0] + (first - from[0]) * share, from[1] + (second - from[1]) * share);
    }
  }
  Vec3 force_N(int tool) const { return -Eigen::Map<const Vec3>(tool_[tool].out.force_on_tool_N); }
  std::size_t ticks() const { return ticks_; }

 private:
  void tick(const Vec3& first, const Vec3& second) {
    at_[0] = first;
    at_[1] = second;
    for (int i = 0; i < 2; ++i) {
      tool_[i].contact = &contact_[i];
      Eigen::Map<Vec3>(tool_[i].place_m) = at_[i];
    }
    touch_together(asset_, joint_, tool_, 2, runtime::kMaxTimeStep_s);
    ++ticks_;
  }

  const runtime::AssetView& asset_;
  runtime::Contact contact_[2];
  runtime::Joint joint_;
  runtime::JointTool tool_[2];
  Vec3 at_[2];
  std::size_t ticks_ = 0;
};

runtime::CouplingView coupling_of(double length_m, const Unknowns& of) {
  runtime::CouplingView out;
  out.length_m = length_m;
  for (int k = 0; k < runtime::kCouplingScales; ++k) {
    out.give_m_N[k] = of[k];
    out.across_m_N[k] = of[runtime::kCouplingScales + k];
  }
  return out;
}

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

// Six a good row: forces less the reference's, each over the scale of its error.
Eigen::VectorXd residual_of(const Samples& samples, const TwoToolForces& answered) {
  const Eigen::VectorXd first = largest_forces(samples, samples.force),
                        second = largest_forces(samples, samples.second_force);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * samples.rows());
  const auto put = [&](Eigen::Index at, const Vec3& off, double force, double largest) {
    const double scale = std::max(force, kLightForce * largest);
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

using Gram = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// argmin x'Gx/2 - g'x over x >= least, by coordinates.
Unknowns bounded_minimum(const Gram& gram, const Unknowns& right, const Unknowns& least) {
  Unknowns x = Unknowns::Zero().cwiseMax(least);
  for (int sweep = 0; sweep < 20000; ++sweep) {
    double moved = 0;
    for (int k = 0; k < kUnknowns; ++k) {
      if (!(gram(k, k) > 0)) continue;
      const double next = std::max(least[k], x[k] + (right[k] - gram.row(k).dot(x)) / gram(k, k));
      moved = std::max(moved, std::abs(next - x[k]));
      x[k] = next;
    }
    if (moved < 1e-12) break;
  }
  return x;
}

// The same with sums of unknowns that are below a limit: sum over k of rows.col(i) x <= limit[i].
// A sum that is not is brought to its limit by a stiff spring, and stays there.
Unknowns limited_minimum(Gram gram, Unknowns right, const Unknowns& least,
                         const Eigen::Matrix<double, kUnknowns, 2>& rows,
                         const Eigen::Vector2d& limit) {
  const double spring = kLimitSpring * gram.diagonal().maxCoeff();
  Unknowns x = bounded_minimum(gram, right, least);
  for (int i = 0; i < 2; ++i) {
    if (rows.col(i).dot(x) <= limit[i]) continue;
    gram += spring * rows.col(i) * rows.col(i).transpose();
    right += spring * limit[i] * rows.col(i);
    x = bounded_minimum(gram, right, least);
  }
  return x;
}

}  // namespace

TwoToolForces replay_two_tools(const runtime::AssetView& asset,
                               const runtime::CouplingView& coupling, const Samples& samples,
                               const std::vector<ToolPath>& paths, double depth_m) {
  TwoToolForces out{Points::Zero(samples.rows(), 3), Points::Zero(samples.rows(), 3)};
  runtime::AssetView view = asset;
  view.coupling = coupling.is_any() ? &coupling : nullptr;
  std::size_t ticks = 0;
  const auto started = std::chrono::steady_clock::now();
  for (Eigen::Index row = 0; row < samples.rows();) {
    const std::int32_t experiment = samples.experiment[static_cast<std::size_t>(row)];
    const ToolPath& path = paths[static_cast<std::size_t>(experiment)];
    const SecondTool& other = *path.second;
    const Vec3 first = samples.point_position.row(path.point),
               normal = samples.point_normal.row(path.point);
    TwoTips tips(view, first - kApproachRatio * depth_m * normal,
                 other.position - kApproachRatio * depth_m * other.normal);
    for (; row < samples.rows() && samples.experiment[static_cast<std::size_t>(row)] == experiment;
         ++row) {
      tips.go(first + samples.deflection.row(row).transpose(),
              other.position + samples.second_deflection.row(row).transpose());
      out.first_N.row(row) = tips.force_N(0);
      out.second_N.row(row) = tips.force_N(1);
    }
    ticks += tips.ticks();
  }
  const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - started;
  out.tick_ns = ticks > 0 ? spent.count() / static_cast<double>(ticks) : 0;
  return out;
}

std::vector<double> two_tool_errors(const Samples& samples, const TwoToolForces& answered) {
  const Eigen::VectorXd residual = residual_of(samples, answered);
  std::vector<double> errors;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    for (int tool = 0; tool < 2; ++tool)
      if (samples.status[static_cast<std::size_t>(row)] == RowStatus::good &&
          (tool == 0 ? samples.force : samples.second_force).row(row).norm() > 0)
        errors.push_back(residual.segment<3>(6 * row + 3 * tool).norm());
  return errors;
}

runtime::CouplingView identify_coupling(const runtime::AssetView& asset, const Samples& samples,
                                        const std::vector<ToolPath>& paths, double depth_m,
                                        double length_m, CouplingReport* report) {
  CouplingReport unused;
  CouplingReport& out = report != nullptr ? *report : unused;
  out = CouplingReport();
  out.pairs = paths.size();
  const auto forces = [&](const Unknowns& x) {
    return replay_two_tools(asset, coupling_of(length_m, x), samples, paths, depth_m);
  };
  const auto quantiles = [&](const Unknowns& x, double& median, double& p95) {
    const std::vector<double> errors = two_tool_errors(samples, forces(x));
    out.rows = errors.size();
    median = quantile(errors, 0.5);
    p95 = quantile(errors, 0.95);
  };
  Unknowns x = Unknowns::Zero(), none = x;
  quantiles(none, out.median_alone, out.p95_alone);
  // What sums of compliances may be: all of the a_k, and with them all of the b_k.
  constexpr int kScales = runtime::kCouplingScales;
  const auto most = [&](int k) {
    return 1 / runtime::coupling_excess(asset, coupling_of(length_m, Unknowns::Unit(k)));
  };
  const double own_m_N = most(0);
  const Eigen::Vector2d limit(kLimit, kLimit * most(kScales) / own_m_N);
  Eigen::Matrix<double, kUnknowns, 2> sums = Eigen::Matrix<double, kUnknowns, 2>::Ones();
  sums.col(0).tail(kScales).setZero();
  Eigen::VectorXd residual = residual_of(samples, forces(x));
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::MatrixXd slope(residual.size(), kUnknowns);
    for (int k = 0; k < kUnknowns; ++k) {
      const double by = kProbed * own_m_N;
      slope.col(k) = (residual_of(samples, forces(x + by * Unknowns::Unit(k))) - residual) / by;
    }
    slope *= own_m_N;
    Gram gram = slope.transpose() * slope;
    gram.diagonal().array() += kRidge * gram.diagonal().maxCoeff();
    const Unknowns here = x / own_m_N;
    const Unknowns way = own_m_N * limited_minimum(gram, -slope.transpose() * residual, -here, sums,
                                                   limit - sums.transpose() * here);
    double share = 1;
    bool is_better = false;
    for (int cut = 0; cut < kMaxHalvings && !is_better; ++cut, share /= 2) {
      const Unknowns next = (x + share * way).cwiseMax(0);
      const Eigen::VectorXd there = residual_of(samples, forces(next));
      is_better = there.squaredNorm() < (1 - 1e-4 * share) * residual.squaredNorm();
      if (!is_better) continue;
      x = next;
      residual = there;
    }
    if (!is_better) break;
  }
  const double excess = runtime::coupling_excess(asset, coupling_of(length_m, x));
  if (excess > 1) {
    out.scaled = 1 / excess;
    x *= out.scaled;
  }
  quantiles(x, out.median, out.p95);
  return x.maxCoeff() > 0 && out.median < kWorth * out.median_alone ? coupling_of(length_m, x)
                                                                    : runtime::CouplingView();
}

}  // namespace palpate
