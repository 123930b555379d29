#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"
#include "tests/support/surfaces.hpp"

namespace palpate::mesh_repair_test {

using testing_support::inside_out;
using testing_support::together;

/// A cube of `edge` [m] at `low`, outward, `pieces` squares along each edge.
Surface box(double edge_m, const Vec3& low = Vec3::Zero(), int pieces = 3);

/// A sphere of about 4 n^2 triangles, outward.
Surface ball(double radius_m, const Vec3& middle = Vec3::Zero(), int n = 12);

/// The surface without the triangles listed.
Surface without(const Surface& surface, const std::vector<Eigen::Index>& triangles);

/// The surface with one more triangle.
Surface with_triangle(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c);

/// Every triangle with three vertices of its own, moved by at most `noise_m` (seeded).
Surface torn(const Surface& surface, double noise_m, unsigned seed);

}  // namespace palpate::mesh_repair_test
