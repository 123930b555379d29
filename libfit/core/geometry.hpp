#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace palpate {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// # x 3, one point or vector per row. Positions in m unless a name says otherwise.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// # x 3 vertex indices, counter-clockwise seen from outside the body.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// # x 4 node indices, positive volume: (n1-n0) x (n2-n0) . (n3-n0) > 0.
using Tets = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;

}  // namespace palpate
