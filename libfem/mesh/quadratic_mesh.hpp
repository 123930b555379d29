#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Index of the material that fills a place [m]; 0 is the body's own.
using RegionAt = std::function<int(const Vec3& rest_position)>;

/// Tells held places of the body at rest [m] from others; a place of its boundary may be where the
/// inside beside it is not.
using HeldAt = std::function<bool(const Vec3& rest_position, bool is_on_boundary)>;

/// Ten-node tetrahedra at rest, what the solver works on.
/// nodes #N x 3 [m]. tets #T x 10: corners 0-3 as in `Tets`, then mid-edge nodes of
/// (0,1) (1,2) (2,0) (0,3) (1,3) (2,3). faces #F x 6: boundary triangles, corners 0-2 outward
/// counter-clockwise, then mid-edge nodes of (0,1) (1,2) (2,0). Mid-edge nodes need not be halfway:
/// where the boundary is curved they lie on it (isoparametric).
/// region: #T, index of the tet's material (0: the body's own); empty means all 0.
/// base: #T, the tet of the base mesh that each is a part of.
/// is_held: #N, displacement fixed to zero. deviation_m: largest distance between a boundary node
/// and the surface it should lie on, where it could not be moved there without spoiling an element;
/// contact_deviation_m: the mean over the nodes that one contact touches, where the mesh is finest,
/// largest of the contacts: what bears on a force.
struct QuadraticMesh {
  Points nodes;
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 10, Eigen::RowMajor> tets;
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 6, Eigen::RowMajor> faces;
  std::vector<char> is_held;
  double deviation_m = 0;
  double contact_deviation_m = 0;
  Eigen::VectorXi region;
  std::vector<std::int32_t> base;
};

}  // namespace palpate::fem
