#include "libfem/solve/experiments/quick_press.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

// Good rows of presses by point and step.
std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> pressed(const Samples& samples) {
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> out;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (samples.kind[at] == ExperimentKind::press && samples.status[at] == RowStatus::good)
      out[{samples.point[at], samples.step[at]}] = i;
  }
  return out;
}

struct PairedRow {
  std::int32_t step;
  double ratio;      // two meshes over one, along the force
  double own_error;  // of the row on two meshes, relative
  double force_N;
};

}  // namespace

QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh) {
  const auto quick = pressed(one_mesh);
  std::map<std::int32_t, std::vector<PairedRow>> points;
  for (const auto& [key, row] : pressed(two_meshes)) {
    const auto found = quick.find(key);
    if (found == quick.end()) continue;
    const Vec3 full = two_meshes.force.row(row), other = one_mesh.force.row(found->second);
    if (!(full.squaredNorm() > 0 && other.dot(full) > 0)) continue;
    points[key.first].push_back({key.second, full.squaredNorm() / other.dot(full),
                                 two_meshes.force_error[row] / full.norm(), full.norm()});
  }
  QuickScale out;
  if (points.empty()) return out;
  std::vector<double> ratios;
  for (const auto& [point, rows] : points) {
    double sum = 0;
    for (const PairedRow& row : rows) sum += row.ratio;
    ratios.push_back(sum / static_cast<double>(rows.size()));
  }
  out.scale = median(ratios);
  std::map<std::int32_t, std::pair<double, std::vector<double>>> steps;
  std::vector<double> left;
  for (const auto& [point, rows] : points) {
    double largest_N = 0;
    for (const PairedRow& row : rows) largest_N = std::max(largest_N, row.force_N);
    for (const PairedRow& row : rows) {
      const double off = std::abs(out.scale / row.ratio - 1);
      auto& [worst, own] = steps[row.step];
      worst = std::max(worst, off);
      if (std::isfinite(row.own_error)) own.push_back(row.own_error);
      left.push_back(relative_error(off * row.force_N, row.force_N, kLightForce * largest_N));
    }
  }
  for (const auto& [step, errors] : steps) {
    out.error.resize(static_cast<std::size_t>(step) + 1, out.error.empty() ? 0 : out.error.back());
    out.error.back() = errors.first + (errors.second.empty() ? 0 : median(errors.second));
  }
  out.p95 = lower_quantile(std::move(left), 0.95);
  return out;
}

}  // namespace palpate::fem
