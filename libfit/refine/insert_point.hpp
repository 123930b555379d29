#pragma once

#include <string>

#include "libfit/core/body.hpp"

namespace palpate {

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
