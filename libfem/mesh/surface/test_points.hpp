#pragma once

#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

inline constexpr int kMinTestPoints = 4;
inline constexpr int kMaxTestPoints = 10000;

/// Test points spread evenly over a region of a surface, and their triangulation.
/// in_region: per vertex. The region is made of the triangles whose corners all are in it; it may
/// be closed, have borders, or be several pieces; where two sheets touch in one vertex the
/// smaller sheet's triangles there are left out. Points are vertices of `fine`, in its order,
/// named "p0001"...; normals are inward, from palpate::vertex_normals of `fine`; triangles are
/// outward. Points on a border stay on it, so that the part stays covered. is_reachable: per
/// vertex, where points may stand; they leave other vertices first, and a few may be left there
/// where topology asks for it: the caller looks.
/// The part is decimated by edge length and quadric error, then points slide to even out.
/// As many points as asked, or the nearest number that keeps the topology (no fewer than 3 per open
/// piece, 4 per closed one); all vertices of the part when it has no more than `count`.
/// Throws Error when count is not 4..10000, the flags do not match the vertices, the reachable
/// part has no triangle, or the surface is not manifold there. Deterministic.
TestPoints choose_test_points(const Surface& fine, const std::vector<char>& in_region,
                              const std::vector<char>& is_reachable, int count);

}  // namespace palpate
