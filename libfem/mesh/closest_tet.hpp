#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

/// The point of a volume (or of one tet) nearest to a query: weight of the tet's corners, sum 1.
struct VolumePoint {
  std::int32_t tet = -1;
  Eigen::Vector4d weight = Eigen::Vector4d::Zero();
  double distance_m = std::numeric_limits<double>::infinity();  ///< 0 inside
};

/// Nearest point of one tet, whose number is left at -1.
VolumePoint nearest_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                           const Vec3& d);

/// Boxes of the tets of a volume, for the query below.
BoxTree tet_boxes(const TetMesh& volume);

/// Nearest point among the tets whose nearest point `accept(VolumePoint)` takes, no farther than
/// max_m; of two as near, that of the lower tet. Empty when there is none. Thread-safe.
template <class Accept>
std::optional<VolumePoint> closest_in_volume(const TetMesh& volume, const BoxTree& boxes,
                                             const Vec3& query, double max_m, Accept&& accept) {
  std::optional<VolumePoint> hit;
  double squared_best = max_m * max_m;
  boxes.visit_nearest(query, squared_best, [&](std::int32_t t, double& best) {
    const auto corner = volume.tets.row(t);
    VolumePoint point =
        nearest_in_tet(query, volume.nodes.row(corner[0]), volume.nodes.row(corner[1]),
                       volume.nodes.row(corner[2]), volume.nodes.row(corner[3]));
    point.tet = t;
    const double squared = point.distance_m * point.distance_m;
    const bool is_better = squared < best || (squared == best && (!hit || t < hit->tet));
    if (!is_better || !accept(static_cast<const VolumePoint&>(point))) return;
    best = squared;
    hit = point;
  });
  return hit;
}

}  // namespace palpate
