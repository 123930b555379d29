#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/point/replay.hpp"
#include "libfit/runtime/asset/view.hpp"
#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// The causes of an asset's error (M11b), a figure each:
/// interpolation, curve_fit, curve_family and friction_law.
/// reference.own must hold presses and drags at held-out points. Paths at other points, and at
/// those whose own curves failed, are left out.
/// engine: the asset's answers along the reference's paths.
std::vector<StatedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                      const Replayed& engine, double depth_m, int jobs);

/// The same paths with something simpler in place of the asset's curves, each with its whole
/// error: one_response (the mean curve everywhere), undamaged (of an asset that softens).
std::vector<StatedError> baseline_errors(const runtime::AssetView& asset,
                                         const Reference& reference, double depth_m);

/// An asset with something else in place of its curves or numbers, for comparisons: same surface,
/// same engine. Views into the asset it was made from, which must outlive it.
class SubstitutedAsset {
 public:
  const runtime::AssetView& view() const { return view_; }

  /// Every vertex of the surface, covered or not, answers with one row of `curves`, on its bases.
  static SubstitutedAsset with_one_response(const runtime::AssetView& asset, const CurveSet& curves,
                                            Eigen::Index row);
  /// Every covered vertex answers with the mean response of all covered ones.
  static SubstitutedAsset with_mean_response(const runtime::AssetView& asset);

 private:
  explicit SubstitutedAsset(const runtime::AssetView& asset);

  runtime::AssetView view_;
  std::unique_ptr<fit::Bases> bases_;
  std::vector<float> control_;
  std::vector<std::int32_t> record_;
  std::vector<std::uint8_t> covered_;
};

/// Length of the gradient of ln f^z along each triangle of the surface of an asset [1/m]: by how
/// much of itself the force of a press to depth_m changes there. 0 where a corner has no curves of
/// its own.
std::vector<double> press_changes(const runtime::AssetView& asset, const Surface& surface,
                                  double depth_m);

/// Basis of one part of an asset; no knots where it is no curve.
CurveBasis basis_of(const runtime::AssetView& asset, int part);

}  // namespace palpate::validation
