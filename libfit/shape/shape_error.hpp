#pragma once

#include <optional>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// The engine's contact at each row of the samples, every experiment replayed from outside at 20 um
/// a tick; a drag is first pressed to its depth. Empty where a row is not good, nothing touches, or
/// an earlier row of its experiment was not good. depth_m: loading begins a tenth of it outside.
std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples, double depth_m);

/// Quantiles of the distance between where the engine shows vertices and where the reference has
/// them [m], and the same over the depth of the row. NaN where there is no such vertex.
struct ShapeErrorFigures {
  double median_m = 0, p95_m = 0, max_m = 0;
  double median_rel = 0, p95_rel = 0, max_rel = 0;
};

/// near: vertices within three contact radii of the contact point; all: every vertex.
/// penetration_m: how deep triangles cut into the tool's ball at most, at the middles of their
/// edges and their own; vertices themselves never do. 0 rows: nothing was compared.
struct ShapeError {
  ShapeErrorFigures near, all;
  double penetration_m = 0;
  std::size_t rows = 0;
};

/// Compares the engine with the motion of the surface in rows of the samples that `counts` names
/// (empty: all), in contacts as contact_states brings them. The depth that errors are shares of is
/// at least a tenth of the deepest that the response knows. is_shown: with the ball pushing
/// vertices out, as palpate_deform does.
ShapeError shape_error(const runtime::AssetView& asset, const Samples& samples,
                       const std::vector<std::optional<runtime::Contact>>& contacts,
                       const std::vector<char>& counts = {}, bool is_shown = true);

}  // namespace palpate
