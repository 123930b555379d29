#pragma once

#include <optional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/shape/shaped_asset.hpp"

namespace palpate {

/// depth_m: deepest press. radius_m: contact radius there, which goes as d^(radius_power / 2).
struct ShapeOptions {
  double depth_m = 0, radius_m = 0;
  int radius_power = 1;
  int intervals = 16;             ///< 10 leave 1.4 times the error on the liver phantom, 24 as much
  std::optional<int> modes = {};  ///< none: by held-out rows
};

/// The numbers of modes that were tried; errors as shares of the depth, p95 over vertices within
/// three contact radii and over all, of the rows of points held out while modes were counted.
struct ShapeReport {
  struct Count {
    int modes;
    double near_p95, all_p95;
  };
  std::vector<Count> tried;
  int rows = 0;
};

/// The shape response of a body from the motion of its surface at test points (docs/method-body.md,
/// section 20). asset: without one, of the same model; blend_point, blend_weight: the model's.
/// samples.surface must have 3V columns. No points where no press at a test point is known.
/// Does not depend on the number of threads.
ShapeResponse identify_shape(const runtime::AssetView& asset, const Samples& samples,
                             const Triangles& blend_point, const Points& blend_weight,
                             const ShapeOptions& options, ShapeReport* report = nullptr);

}  // namespace palpate
