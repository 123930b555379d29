// (h): a small neural network from where a proxy is and how far the tool is from it to force.

#include "tools/workshop/rivals/neural.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <random>

#include "libfit/core/stated_error.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/finger_proxy.hpp"

namespace palpate::tools {
namespace {

constexpr int kHidden[] = {16, 32}, kEpochs = 3000;
constexpr double kRate = 1e-2;

// What the network sees: the proxy's place about the window's middle, over the window's radius, and
// the deflection over the depth; and what its output is multiplied by, so that no deflection has
// no force.
struct Features {
  Vec3 middle;
  double radius_m, depth_m;

  Eigen::VectorXd of(const Vec3& place, const Vec3& deflection) const {
    Eigen::VectorXd out(6);
    out << (place - middle) / radius_m, deflection / depth_m;
    return out;
  }
  double factor(const Vec3& deflection) const { return deflection.norm() / depth_m; }
};

Vec3 eigen(const runtime::Vec3d& v) { return {v.x, v.y, v.z}; }

struct TrainingRows {
  Eigen::MatrixXd input, target;
  Eigen::VectorXd weight;
};

// Where the proxy of the tool is at the rows of presses and drags, as it will be when played.
TrainingRows training_rows(const RivalBody& body, const Features& features, double cone) {
  const Samples& samples = body.samples;
  const double floor_N = relative_floor_N(samples);
  std::vector<Eigen::VectorXd> input;
  std::vector<Vec3> target;
  std::vector<double> weight;
  std::optional<FingerProxy> proxy;
  Vec3 at = Vec3::Zero();
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    const Vec3 position = samples.point_position.row(samples.point[r]),
               inward = samples.point_normal.row(samples.point[r]),
               to = position + Vec3(samples.deflection.row(row));
    Vec3 deflection = Vec3::Zero();
    const auto go = [&](const Vec3& end) {
      const Vec3 from = at;
      const int steps = std::max(1, static_cast<int>(std::ceil((end - from).norm() / kWalkTick_m)));
      for (int k = 1; k <= steps; ++k) {
        at = from + (end - from) * (double(k) / steps);
        deflection = eigen(proxy->deflection(at.data()));
      }
    };
    if (row == 0 || samples.experiment[r] != samples.experiment[r - 1]) {
      proxy.emplace(body.asset.asset(), 1.0, cone);
      at = position - kApproachRatio * body.depth_m * inward;
      proxy->deflection(at.data());
      if (samples.kind[r] == ExperimentKind::drag)
        go(position + (to - position).dot(inward) * inward);
    }
    go(to);
    if (samples.status[r] != RowStatus::good || deflection.isZero()) continue;
    const Vec3 force = samples.force.row(row);
    const double factor = features.factor(deflection);
    input.push_back(features.of(eigen(proxy->place()), deflection));
    target.push_back(force / factor);
    weight.push_back(factor * factor / (force.squaredNorm() + floor_N * floor_N));
  }
  TrainingRows out;
  const auto count = static_cast<Eigen::Index>(input.size());
  out.input.resize(6, count), out.target.resize(3, count), out.weight.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    out.input.col(i) = input[k], out.target.col(i) = target[k], out.weight[i] = weight[k];
  }
  return out;
}

}  // namespace

SmallNetwork::SmallNetwork(int inputs, int hidden, int outputs, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const int sizes[] = {inputs, hidden, hidden, outputs};
  for (int layer = 0; layer < 3; ++layer) {
    const double bound = std::sqrt(6.0 / (sizes[layer] + sizes[layer + 1]));
    Eigen::MatrixXd weight(sizes[layer + 1], sizes[layer]);
    for (double& each : weight.reshaped())
      each = bound * (2 * (double(random() >> 11) / 9007199254740992.0) - 1);
    parameter_.push_back(std::move(weight));
    parameter_.push_back(Eigen::MatrixXd::Zero(sizes[layer + 1], 1));
  }
}

Eigen::VectorXd SmallNetwork::operator()(const Eigen::VectorXd& input) const {
  const Eigen::VectorXd first = (parameter_[0] * input + parameter_[1]).array().tanh();
  const Eigen::VectorXd second = (parameter_[2] * first + parameter_[3]).array().tanh();
  return parameter_[4] * second + parameter_[5];
}

double SmallNetwork::loss(const Eigen::MatrixXd& input, const Eigen::MatrixXd& target,
                          const Eigen::VectorXd& weight,
                          std::vector<Eigen::MatrixXd>& gradient) const {
  const auto layer = [&](int k, const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
    return (parameter_[static_cast<std::size_t>(2 * k)] * x).colwise() +
           parameter_[static_cast<std::size_t>(2 * k + 1)].col(0);
  };
  const Eigen::MatrixXd first = layer(0, input).array().tanh(),
                        second = layer(1, first).array().tanh(), off = layer(2, second) - target;
  const double mean = 1 / static_cast<double>(input.cols());
  const Eigen::MatrixXd by_out = 2 * mean * off * weight.asDiagonal();
  const Eigen::MatrixXd by_second =
      (parameter_[4].transpose() * by_out).array() * (1 - second.array().square());
  const Eigen::MatrixXd by_first =
      (parameter_[2].transpose() * by_second).array() * (1 - first.array().square());
  gradient = {by_first * input.transpose(),  by_first.rowwise().sum(),
              by_second * first.transpose(), by_second.rowwise().sum(),
              by_out * second.transpose(),   by_out.rowwise().sum()};
  return mean * off.colwise().squaredNorm().dot(weight);
}

double SmallNetwork::train(const Eigen::MatrixXd& input, const Eigen::MatrixXd& target,
                           const Eigen::VectorXd& weight, int epochs, double rate) {
  constexpr double kFirst = 0.9, kSecond = 0.999, kSmall = 1e-8;
  std::vector<Eigen::MatrixXd> gradient, mean, square;
  double last = 0;
  for (int epoch = 1; epoch <= epochs; ++epoch) {
    last = loss(input, target, weight, gradient);
    if (epoch == 1)
      for (const Eigen::MatrixXd& each : gradient)
        mean.push_back(Eigen::MatrixXd::Zero(each.rows(), each.cols()));
    if (epoch == 1) square = mean;
    const double falling = 0.5 * (1 + std::cos(std::numbers::pi * epoch / epochs));
    const double step = rate * (0.01 + 0.99 * falling);
    for (std::size_t k = 0; k < parameter_.size(); ++k) {
      mean[k] = kFirst * mean[k] + (1 - kFirst) * gradient[k];
      square[k] = kSecond * square[k].array() + (1 - kSecond) * gradient[k].array().square();
      parameter_[k].array() -=
          step * (mean[k].array() / (1 - std::pow(kFirst, epoch))) /
          ((square[k].array() / (1 - std::pow(kSecond, epoch))).sqrt() + kSmall);
    }
  }
  return last;
}

std::size_t SmallNetwork::numbers() const {
  std::size_t count = 0;
  for (const Eigen::MatrixXd& each : parameter_) count += static_cast<std::size_t>(each.size());
  return count;
}

std::vector<Rival> prepare_neural(const RivalBody& body) {
  const Points& place = body.samples.point_position;
  Features features{place.colwise().mean().transpose(), 0, body.depth_m};
  features.radius_m = (place.rowwise() - features.middle.transpose()).rowwise().norm().maxCoeff();
  const double cone = drag_ratio(body.samples);
  std::vector<Rival> out;
  for (const int hidden : kHidden) {
    const double began_s = cpu_seconds();
    const TrainingRows rows = training_rows(body, features, cone);
    const auto network = std::make_shared<SmallNetwork>(6, hidden, 3, 1);
    const double loss = network->train(rows.input, rows.target, rows.weight, kEpochs, kRate);
    Rival rival;
    rival.preparation_cpu_s = cpu_seconds() - began_s + simulation_cpu_s(body, body.samples);
    rival.name = "neural network";
    rival.size = hidden;
    rival.bytes = network->numbers() * sizeof(double) + surface_bytes(body.asset.asset());
    rival.settings = fmt::format(
        "two layers of {} tanh behind a proxy (cone {:.2f}), {} rows of {} test points, Adam, {} "
        "epochs; {:.1f} % left on these rows (rms)",
        hidden, cone, rows.input.cols(), body.samples.points(), kEpochs, 100 * std::sqrt(loss));
    const auto proxy = std::make_shared<std::optional<FingerProxy>>();
    rival.start = [proxy, cone, &asset = body.asset.asset()](const Vec3&) {
      proxy->emplace(asset, 1.0, cone);
    };
    rival.force = [proxy, network, features](const Vec3& tip) -> Vec3 {
      const Vec3 deflection = eigen((*proxy)->deflection(tip.data()));
      if (deflection.isZero()) return Vec3::Zero();
      return features.factor(deflection) *
             (*network)(features.of(eigen((*proxy)->place()), deflection));
    };
    out.push_back(std::move(rival));
  }
  return out;
}

}  // namespace palpate::tools
