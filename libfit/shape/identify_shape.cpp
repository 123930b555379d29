#include "libfit/shape/identify_shape.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "libfit/shape/response_fit.hpp"
#include "libfit/shape/shape_error.hpp"

namespace palpate {
namespace {

constexpr std::array kModeCounts{0, 2, 4, 6, 8, 12, 16, 24};
/// The fewest modes are taken whose error is within this of the best. A mode is 12 bytes a
/// vertex: on the liver phantom 6 leave 2.7 and 1.2 % (near, everywhere), 16 leave 2.5 and 1.0 for
/// 0.5 MB more.
constexpr double kAsGood = 1.2;

/// The same response with its first modes alone.
ShapeResponse with_modes(const ShapeResponse& shape, int modes) {
  ShapeResponse out = shape;
  const int M = shape.intervals, pressed = runtime::shape_numbers(M, 0);
  out.modes = modes;
  out.point.resize(shape.point.rows(), runtime::shape_numbers(M, modes));
  out.point.leftCols(pressed) = shape.point.leftCols(pressed);
  for (int axis = 0; axis < 3; ++axis)
    out.point.middleCols(pressed + axis * modes, modes) =
        shape.point.middleCols(pressed + axis * shape.modes, modes);
  out.mode = shape.mode.leftCols(3 * modes);
  return out;
}

/// Every third point is left out while modes are counted.
constexpr bool is_left_out(Eigen::Index point) { return point % 3 == 1; }

/// Numbers of points left out: those of the three nearest others, by their squared distance.
ShapeResponse filled_in(ShapeResponse shape, const Points& position) {
  for (Eigen::Index p = 0; p < position.rows(); ++p) {
    if (!is_left_out(p)) continue;
    std::vector<std::pair<double, Eigen::Index>> near;
    for (Eigen::Index other = 0; other < position.rows(); ++other)
      if (!is_left_out(other))
        near.emplace_back((position.row(other) - position.row(p)).squaredNorm(), other);
    std::sort(near.begin(), near.end());
    near.resize(std::min<std::size_t>(near.size(), 3));
    shape.point.row(p).setZero();
    double sum = 0;
    for (const auto& [squared, other] : near) {
      shape.point.row(p) += shape.point.row(other) / squared;
      sum += 1 / squared;
    }
    shape.point.row(p) /= sum;
  }
  return shape;
}

}  // namespace

ShapeResponse identify_shape(const runtime::AssetView& asset, const Samples& samples,
                             const Triangles& blend_point, const Points& blend_weight,
                             const ShapeOptions& options, ShapeReport* report) {
  ResponseFit fit(asset, samples, blend_point, blend_weight, options);
  int modes = options.modes.value_or(0);
  if (!options.modes) {
    // Modes that differ from point to point alone do not help between points.
    std::vector<char> is_held_out(samples.point.size()), is_fitted(is_held_out);
    for (std::size_t row = 0; row < is_held_out.size(); ++row)
      (is_left_out(samples.point[row]) ? is_held_out : is_fitted)[row] = fit.is_measured(row);
    const ShapeResponse most =
        filled_in(fit.of(is_fitted, kModeCounts.back()), samples.point_position);
    std::vector<ShapeReport::Count> tried;
    double best = std::numeric_limits<double>::infinity();
    for (const int count : kModeCounts) {
      if (count > most.modes) break;
      const ShapedAsset shaped(asset, with_modes(most, count), blend_point, blend_weight);
      const ShapeError error = shape_error(shaped.view(), samples, fit.contacts(), is_held_out);
      tried.push_back({count, error.near.p95_rel, error.all.p95_rel});
      best = std::min(best, error.near.p95_rel + error.all.p95_rel);
    }
    for (const ShapeReport::Count& count : tried)
      if (count.near_p95 + count.all_p95 <= kAsGood * best) {
        modes = count.modes;
        break;
      }
    if (report != nullptr) report->tried = tried;
  }
  ShapeResponse shape = fit.of({}, modes);
  if (report != nullptr) report->rows = int(fit.rows());
  if (fit.rows() == 0) return {};
  return shape;
}

}  // namespace palpate
