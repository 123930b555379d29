#include "libfit/core/samples.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace palpate {
namespace {

constexpr double kRounding = 1e-6;  // of the depth
// Share of the depth, tan 20 degrees: rigs and normals of surfaces are off by a few degrees, and a
// tool that slides on purpose goes farther.
constexpr double kSideways = 0.36;
constexpr double kWindowShare = 0.25;  // of the rows whose mean is a place, not noise
constexpr double kSeenInErrors = 4;

using RowNumbers = std::vector<Eigen::Index>;

std::map<std::int32_t, RowNumbers> rows_of_presses(const Samples& samples) {
  std::map<std::int32_t, RowNumbers> out;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const ExperimentKind kind = samples.kind[i];
    if (kind == ExperimentKind::press || kind == ExperimentKind::cycle)
      out[samples.experiment[i]].push_back(i);
  }
  for (auto& [number, rows] : out)
    std::ranges::stable_sort(rows, {}, [&](Eigen::Index i) { return samples.step[i]; });
  return out;
}

Vec3 inward_at(const Samples& samples, Eigen::Index row) {
  return samples.point_normal.row(samples.point[row]);
}

Vec3 lateral(const Vec3& vector, const Vec3& inward) {
  return vector - vector.dot(inward) * inward;
}

// Farthest that the mean of neighbouring rows lies beside the normal.
double sideways_m(const std::vector<Vec3>& aside) {
  const auto window = std::max<std::size_t>(
      2, static_cast<std::size_t>(kWindowShare * static_cast<double>(aside.size())));
  double most = 0;
  for (std::size_t first = 0; first + window <= aside.size(); ++first) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < window; ++k) sum += aside[first + k];
    most = std::max(most, sum.norm() / static_cast<double>(window));
  }
  return most;
}

// True if force goes along lateral motion, by more than what scatters about that.
bool is_friction_seen(const std::vector<Vec3>& aside, const std::vector<Vec3>& force) {
  double squares = 0, along = 0, left = 0;
  for (std::size_t i = 0; i < aside.size(); ++i)
    squares += aside[i].squaredNorm(), along += force[i].dot(aside[i]);
  const double stiffness = along / squares;
  for (std::size_t i = 0; i < aside.size(); ++i)
    left += (force[i] - stiffness * aside[i]).squaredNorm();
  const double variance = left / static_cast<double>(2 * aside.size() - 1);
  return stiffness > kSeenInErrors * std::sqrt(variance / squares);
}

bool is_usable(const Samples& samples, Eigen::Index row) {
  return samples.status[row] == RowStatus::good && samples.deflection.row(row).allFinite() &&
         samples.force.row(row).allFinite();
}

bool is_on_purpose(const Samples& samples, const RowNumbers& rows) {
  std::vector<Vec3> aside, force;
  double deepest_m = 0;
  for (const Eigen::Index i : rows) {
    if (!is_usable(samples, i)) continue;
    const Vec3 inward = inward_at(samples, i), deflection = samples.deflection.row(i);
    deepest_m = std::max(deepest_m, deflection.dot(inward));
    aside.push_back(lateral(deflection, inward));
    force.push_back(lateral(samples.force.row(i), inward));
  }
  return aside.size() > 2 && sideways_m(aside) > kSideways * deepest_m &&
         is_friction_seen(aside, force);
}

bool is_crooked(const Samples& samples, const RowNumbers& rows) {
  double deepest_m = 0, most_m = 0;
  for (const Eigen::Index i : rows) {
    const Vec3 inward = inward_at(samples, i), deflection = samples.deflection.row(i);
    if (!deflection.allFinite()) continue;
    deepest_m = std::max(deepest_m, deflection.dot(inward));
    most_m = std::max(most_m, lateral(deflection, inward).norm());
  }
  return deepest_m > 0 && most_m > kRounding * deepest_m;
}

}  // namespace

std::vector<std::int32_t> straighten_presses(Samples& samples) {
  std::vector<std::int32_t> on_purpose;
  for (const auto& [number, rows] : rows_of_presses(samples)) {
    if (!is_crooked(samples, rows)) continue;
    if (is_on_purpose(samples, rows)) {
      on_purpose.push_back(number);
      continue;
    }
    for (const Eigen::Index i : rows) {
      const Vec3 inward = inward_at(samples, i);
      samples.deflection.row(i) = samples.deflection.row(i).dot(inward) * inward;
      samples.force.row(i) = samples.force.row(i).dot(inward) * inward;
    }
  }
  return on_purpose;
}

bool has_crooked_press(const Samples& samples) {
  return std::ranges::any_of(rows_of_presses(samples), [&](const auto& press) {
    return is_crooked(samples, press.second) && !is_on_purpose(samples, press.second);
  });
}

}  // namespace palpate
