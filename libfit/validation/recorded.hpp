#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/refine/choose_interpolation.hpp"
#include "libfit/runtime/asset/view.hpp"
#include "libfit/validation/replay.hpp"

// Recordings against an asset that was made of others: baselines beside it, and places where it
// answers at all.

namespace palpate::validation {

/// The way in of a press, ever deeper from first touch on: depths [m] and forces along the inward
/// normal [N].
struct PressTable {
  std::vector<double> depth_m{0}, push_N{0};

  /// Straight between rows, and beyond the last as between the last two; of two rows or more.
  double at(double depth_m) const;
};
/// The presses of the good rows of samples, by the points that have any.
std::map<std::int32_t, std::vector<PressTable>> presses_of(const Samples& samples);

/// Answers to the good rows of presses in `asked`: what the presses of the nearest `neighbours`
/// points of `fitted` felt at that depth, weighted with distance to the power -2 (Shepard 1968),
/// along the asked normal. Between rows a press is straight, and beyond its last it goes on as
/// between the last two. A point never answers for its own place, so that `asked` may be `fitted`.
/// Other rows are not answered.
Replayed neighbouring_presses(const Samples& fitted, const Samples& asked, int neighbours);

/// The same by what refine() found by leaving points out: rows of those points alone.
Replayed left_out_presses(const FittedCurves& curves, const InterpolationChoice& found,
                          const Samples& asked);

/// Places of samples on the surface of an asset, P each.
struct PlacedPoints {
  Points position;               ///< the nearest place of the surface [m]
  Eigen::VectorXd distance_m;    ///< from the sample's own place
  std::vector<char> is_covered;  ///< whether the asset has curves of its own there
};
PlacedPoints placed_points(const runtime::AssetView& asset, const Samples& samples);

}  // namespace palpate::validation
