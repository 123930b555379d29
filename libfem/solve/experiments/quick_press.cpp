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
  double ratio;               // two meshes over one, along the force
  double own_error;           // of the row on two meshes, relative
  double force_N, largest_N;  // of the row, of its point
};

}  // namespace

QuickScale compare_quick(const Samples& two_meshes, const Samples& one_mesh) {
  const auto quick = pressed(one_mesh), full = pressed(two_meshes);
  std::map<std::int32_t, double> largest_N;  // by point
  for (const auto& [key, row] : full)
    largest_N[key.first] = std::max(largest_N[key.first], two_meshes.force.row(row).norm());
  std::map<std::int32_t, std::vector<PairedRow>> steps;
  for (const auto& [key, row] : full) {
    const auto found = quick.find(key);
    if (found == quick.end()) continue;
    const Vec3 force = two_meshes.force.row(row), other = one_mesh.force.row(found->second);
    if (!(force.squaredNorm() > 0 && other.dot(force) > 0)) continue;
    steps[key.second].push_back({force.squaredNorm() / other.dot(force),
                                 two_meshes.force_error[row] / force.norm(), force.norm(),
                                 largest_N[key.first]});
  }
  QuickScale out;
  std::vector<double> left;
  for (const auto& [step, rows] : steps) {
    std::vector<double> ratios, own;
    for (const PairedRow& row : rows) {
      ratios.push_back(row.ratio);
      if (std::isfinite(row.own_error)) own.push_back(row.own_error);
    }
    const double scale = median(ratios);
    double worst = 0;
    for (const PairedRow& row : rows) {
      const double off = std::abs(scale / row.ratio - 1);
      worst = std::max(worst, off);
      left.push_back(relative_error(off * row.force_N, row.force_N, kLightForce * row.largest_N));
    }
    // A step that no point reached on both has what the one before it has.
    const auto size = static_cast<std::size_t>(step) + 1;
    out.scale.resize(size, out.scale.empty() ? scale : out.scale.back());
    out.error.resize(size, out.error.empty() ? 0 : out.error.back());
    out.scale.back() = scale;
    out.error.back() = worst + (own.empty() ? 0 : median(own));
  }
  if (!left.empty()) out.p95 = lower_quantile(std::move(left), 0.95);
  return out;
}

}  // namespace palpate::fem
