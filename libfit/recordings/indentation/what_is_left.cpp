#include "libfit/recordings/indentation/what_is_left.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/recordings/relaxation/sensor_noise.hpp"

namespace palpate::recordings {
namespace {

constexpr double kMaxCorrelation = 0.98;
constexpr Eigen::Index kBlocks = 150;  // of rows, whose covariance is found
// Of a pattern in what is left: runs of one sign over the parts are 5 or fewer of 20 once in 200
// presses of white noise, and a share of the force below this moves no modulus by much.
constexpr int kMostRuns = 5;
constexpr double kLeastPattern = 0.003;
constexpr double kAboveNoise = 3;  // squares of parts over those of white noise
constexpr double kAboveWaves = 2;  // of what is left in parts of the free travel

}  // namespace

double PartMeans::rms() const {
  const double parts = static_cast<double>((count.array() > 0).count());
  return parts > 0 ? std::sqrt(mean.squaredNorm() / parts) : 0;
}

int PartMeans::runs() const {
  int runs = 0;
  double before = 0;
  for (Eigen::Index k = 0; k < mean.size(); ++k) {
    if (!(count[k] > 0)) continue;
    runs += runs == 0 || (mean[k] > 0) != (before > 0);
    before = mean[k];
  }
  return runs;
}

double correlation_time(const Eigen::VectorXd& left) {
  const double alone = left.squaredNorm();
  const Eigen::Index n = left.size();
  double time = 1;
  for (Eigen::Index lag = 1; alone > 0 && lag < n / 4; ++lag) {
    const double r = left.head(n - lag).dot(left.tail(n - lag)) / alone;
    if (r < 2 / std::sqrt(static_cast<double>(n))) break;
    time += 2 * std::min(r, kMaxCorrelation);
  }
  return time;
}

Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& left) {
  const Eigen::Index n = left.size(), blocks = std::min(n, kBlocks), unknowns = columns.cols();
  Eigen::MatrixXd slopes(blocks, unknowns);
  Eigen::VectorXd mean(blocks), noise(blocks), count(blocks), at(blocks);
  for (Eigen::Index k = 0; k < blocks; ++k) {
    const Eigen::Index first = k * n / blocks, rows = (k + 1) * n / blocks - first;
    slopes.row(k) = columns.middleRows(first, rows).colwise().mean();
    mean[k] = left.segment(first, rows).mean();
    count[k] = static_cast<double>(rows), noise[k] = 1 / std::sqrt(count[k]);
    at[k] = static_cast<double>(first) + count[k] / 2;
  }
  const double scale = std::max(left.norm() / std::sqrt(static_cast<double>(n)), 1e-300);
  const Eigen::MatrixXd rows =
      scale * scale *
      sensor_covariance(at, noise, Eigen::VectorXd::Ones(blocks), mean / scale, slopes);
  const Eigen::MatrixXd weighted = count.asDiagonal() * slopes;
  const Eigen::MatrixXd inverse = ldlt_inverse(slopes.transpose() * weighted);
  return inverse * weighted.transpose() * rows * weighted * inverse;
}

PartMeans part_means(const Eigen::VectorXd& x, const Eigen::VectorXd& left, double from,
                     double to) {
  PartMeans out{Eigen::VectorXd::Zero(kParts), Eigen::VectorXd::Zero(kParts)};
  for (Eigen::Index i = 0; i < left.size(); ++i) {
    const double share = (x[i] - from) / (to - from);
    if (!(share > 0) || share > 1) continue;
    const auto part = std::min<Eigen::Index>(kParts - 1, static_cast<Eigen::Index>(share * kParts));
    out.mean[part] += left[i], out.count[part] += 1;
  }
  for (Eigen::Index k = 0; k < kParts; ++k) out.mean[k] /= std::max(1., out.count[k]);
  return out;
}

double noise_variance(const Eigen::VectorXd& left) {
  double sum = 0;
  for (Eigen::Index i = 1; i < left.size(); ++i) sum += std::pow(left[i] - left[i - 1], 2);
  return sum / (2 * static_cast<double>(left.size() - 1));
}

double misfit_of(const PartMeans& parts, double noise) {
  double squares = 0;
  int n = 0;
  for (Eigen::Index k = 0; k < kParts; ++k)
    if (parts.count[k] > 0) squares += parts.mean[k] * parts.mean[k] - noise / parts.count[k], ++n;
  return std::sqrt(std::max(0., squares / std::max(1, n)));
}

bool has_pattern(const Eigen::VectorXd& x, const Eigen::VectorXd& left, double contact,
                 double force) {
  const PartMeans pressed = part_means(x, left, contact, x.maxCoeff());
  if ((pressed.count.array() > 0).count() < kParts || pressed.rms() < kLeastPattern * force)
    return false;
  const double squares = pressed.mean.cwiseAbs2().dot(pressed.count) / kParts;
  if (pressed.runs() > kMostRuns && squares < kAboveNoise * noise_variance(left)) return false;
  const double depth = x.maxCoeff() - contact;
  // As long a part of the free travel as the press is deep, or what there is of it.
  const PartMeans free = part_means(x, left, std::max(0., contact - depth), contact);
  return (free.count.array() > 0).count() < kParts / 2 || pressed.rms() > kAboveWaves * free.rms();
}

}  // namespace palpate::recordings
