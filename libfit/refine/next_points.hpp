#pragma once

#include <string>
#include <vector>

#include "libfit/refine/refine.hpp"

namespace palpate {

/// Choice of the next test points.
struct NextPointsOptions {
  int count = 4;
  /// Share of them that fill the largest gaps, whatever is expected there: a feature that no test
  /// point has touched shows in no curve.
  double gap_share = 0.25;
  /// Expected error at the middle of the largest gap when nothing speaks for any [1].
  double gap_error = 0.02;
  /// No pick is as near as this to another point [m].
  double least_m = 0;
};

/// Vertices to experiment at next, best first: those where interpolation is expected to be most
/// wrong. A pick lowers what is expected around it with the square of the distance to the nearest
/// point, so picks spread by themselves; the gap share goes to vertices farthest from every point.
/// expected_error: #V. is_candidate: #V. points: where the test points sit on the surface.
/// Fewer than count when candidates run out, or are all nearer than least_m. Deterministic; ties go
/// to the lower vertex.
std::vector<std::int32_t> next_points(const Surface& fine, const std::vector<char>& is_candidate,
                                      const std::vector<EdgePathSeeds>& points,
                                      std::vector<double> expected_error,
                                      const NextPointsOptions& options);

/// Expected error of interpolation between test points at each vertex of a model, relative to the
/// force there (M12a), (M12b). #V; 0 where not covered. curves: what the model was refined from.
/// refined: what refine() reported. floor_N: forces below it count as it. Curves are compared at
/// four depths; normal force and limit force both count. Points whose fit is poor are compared with
/// none: what they differ by is no feature of the body to be sought. Exact up to third order for
/// smooth fields; of features smaller than the spacing it shows that neighbours disagree, not how
/// much is hidden between them.
std::vector<double> expected_errors(const FittedCurves& curves, const Model& model,
                                    const RefineReport& refined, double floor_N);

/// A test point to be added: where it is [m], its inward unit normal, and a point of the
/// triangulation that answers for this place (Model::blend_point), where the search begins.
struct NewTestPoint {
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  std::string name;
  std::int32_t near = 0;
};

/// Adds a point to a triangulation of test points: splits the triangle of compatible normal nearest
/// to it among the three rings around `near`, or the border edge beside it, and flips edges until
/// no angle sum across an edge exceeds 180 degrees (Lawson 1977, Software for C1 surface
/// interpolation). The triangulation stays manifold with the same outline, but for border points:
/// the outline then goes through them. Returns whether it was added: a point at an existing one, or
/// with no triangle around that faces as it does, or off a corner of the outline, is not.
/// Deterministic. O(T).
bool insert_point(TestPoints& points, const NewTestPoint& added);

}  // namespace palpate
