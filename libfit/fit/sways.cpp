#include <cmath>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

/// Motion across the normal under a unit force along it (M33b). Nothing without a good press.
std::optional<Vec3> coupling(const Samples& samples, std::size_t point, const Mat3& C,
                             const RingPrior& rings) {
  const Vec3 n = samples.point_normal.row(static_cast<Eigen::Index>(point)).transpose();
  std::vector<Vec3> forces, deflections;
  double most_N = 0;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const Vec3 force = samples.force.row(i);
    if (samples.point[i] != static_cast<std::int32_t>(point) ||
        samples.kind[i] != ExperimentKind::press || samples.status[i] != RowStatus::good ||
        !(force.dot(n) > 0))
      continue;
    forces.push_back(force);
    deflections.emplace_back(samples.deflection.row(i));
    most_N = std::max(most_N, force.dot(n));
  }
  if (forces.empty()) return std::nullopt;
  const double lambda = rings.at(std::log(most_N))[0];
  Vec3 sum = Vec3::Zero();
  double square = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double along_N = forces[i].dot(n), depth_m = (deflections[i] - C * forces[i]).dot(n);
    const Vec3 aside_N = forces[i] - along_N * n;
    sum -= depth_m / lambda * aside_N + along_N * (C * aside_N);
    square += along_N * along_N;
  }
  return (sum - sum.dot(n) * n) / square;
}

}  // namespace

std::vector<Mat3> sways_of(const Samples& samples, double share) {
  std::vector<Mat3> out;
  for (const auto& numbers : samples.point_sway.rowwise())
    out.push_back(share * symmetric_of(numbers));
  return out;
}

std::vector<Mat3> turned_sways(const Samples& samples, std::vector<Mat3> sways,
                               const RingPrior& rings) {
  for (std::size_t p = 0; p < sways.size(); ++p) {
    std::optional<Vec3> across = coupling(samples, p, sways[p], rings);
    if (!across) continue;
    const Vec3 n = samples.point_normal.row(static_cast<Eigen::Index>(p)).transpose();
    const Vec3 change = *across - (sways[p] * n - n.dot(sways[p] * n) * n);
    const Mat3 turn = n * change.transpose() + change * n.transpose();
    // A thousandth of the largest stays positive when rounded to float.
    const auto is_sound = [](const Mat3& C) {
      const Vec3 values = symmetric_eigen(C).values;
      return values.minCoeff() >= 1e-3 * values.maxCoeff();
    };
    double share = 1;
    while (share > 1e-3 && !is_sound(sways[p] + share * turn)) share *= 0.9;
    if (share > 1e-3) sways[p] += share * turn;
  }
  return sways;
}

}  // namespace palpate::fit
