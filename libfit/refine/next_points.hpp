#pragma once

#include <vector>

#include "libfit/refine/edge_paths.hpp"

namespace palpate {

/// Where the next test points go.
struct NextPointsOptions {
  int count = 4;
  /// Share of them that fill the largest gaps, whatever is expected there: a feature that no test
  /// point has felt shows in no curve.
  double gap_share = 0.25;
  /// Expected error at the middle of the largest gap when nothing speaks for any [1].
  double gap_error = 0.02;
};

/// Vertices to experiment at next, best first: those where interpolation is expected to be most
/// wrong. A pick lowers what is expected around it with the square of the distance to the nearest
/// point, so picks spread by themselves; the gap share goes to vertices farthest from every point.
/// expected_error: #V. is_candidate: #V. points: where the test points sit on the surface.
/// Fewer than count when candidates run out. Deterministic; ties go to the lower vertex.
std::vector<std::int32_t> next_points(const Surface& fine, const std::vector<char>& is_candidate,
                                      const std::vector<EdgePathSeeds>& points,
                                      std::vector<double> expected_error,
                                      const NextPointsOptions& options);

}  // namespace palpate
