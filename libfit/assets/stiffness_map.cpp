#include "libfit/assets/stiffness_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/node_forces.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

// The page reads the same file (tools/page/src/colours.ts).
constexpr std::uint8_t kAnchors[] = {
#include "libfit/assets/viridis.inc"
};
constexpr std::size_t kIntervals = std::size(kAnchors) / 3 - 1;

}  // namespace

Rgb viridis(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * kIntervals;
  const std::size_t k = std::min(std::size_t(at), kIntervals - 1);
  Rgb out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = kAnchors[3 * k + i], high = kAnchors[3 * k + 3 + i];
    out[i] = static_cast<std::uint8_t>(std::lround(low + (at - double(k)) * (high - low)));
  }
  return out;
}

void check_sizes(const Model& model) {
  if (model.surface.vertices.rows() == 0 || !has_matching_arrays(model))
    throw Error("model", "it has no vertices, or its arrays differ in size",
                "Make the model again with `palpate refine`.");
}

StiffnessMap stiffness_map(const Model& model, double depth_m) {
  check_sizes(model);
  const double range_m = model.curves.basis[0].knots_m.back();
  if (!(depth_m >= 0 && depth_m <= range_m))
    throw Error("--depth", "it lies beyond the curves, which end at " + millimetres(range_m),
                "Give a depth up to there.");
  StiffnessMap map;
  map.depth_m = depth_m > 0 ? depth_m : range_m / 2;
  map.low_N_m = std::numeric_limits<double>::infinity();
  const NodeForces forces(model.curves);
  for (std::size_t v = 0; v < model.is_covered.size(); ++v) {
    const double slope = model.is_covered[v] ? forces.normal_slope_N_m(v, map.depth_m)
                                             : std::numeric_limits<double>::quiet_NaN();
    map.stiffness_N_m.push_back(float(slope));
    if (!model.is_covered[v]) continue;
    map.low_N_m = std::min(map.low_N_m, slope);
    map.high_N_m = std::max(map.high_N_m, slope);
  }
  const double width = map.high_N_m - map.low_N_m;
  for (std::size_t v = 0; v < model.is_covered.size(); ++v)
    map.colour.push_back(!model.is_covered[v] ? kUncoveredGrey
                         : width > 0 ? viridis((map.stiffness_N_m[v] - map.low_N_m) / width)
                                     : viridis(0.5));
  return map;
}

}  // namespace palpate
