#pragma once

#include "libfit/core/closest_point.hpp"

namespace palpate {

/// Distance [m] along a surface from a point of it to each vertex, #V; infinite where no way leads.
/// Fast marching: a front goes over the triangles as if it were plane in each, exact on a plane but
/// for the start; where a triangle is obtuse it may run along an edge and come late.
/// Source: Kimmel and Sethian 1998, doi:10.1073/pnas.95.15.8431.
Eigen::VectorXd geodesic_distance_m(const Surface& surface, const SurfacePoint& from);

}  // namespace palpate
