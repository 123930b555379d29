#pragma once

#include "libfem/mesh/surface/sizing.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate {

/// A surface with the shape of `fine` and edges of about `wanted_m` (#V, per fine vertex [m]),
/// vertices on `fine`, edges sharper than `feature_angle_deg` kept as edges.
/// fine: closed, manifold, outward. The result is closed and manifold; whether it crosses itself
/// or strays is for the caller to check. Deterministic.
/// Source: Botsch and Kobbelt 2004, doi:10.1145/1057432.1057457 (split, collapse, flip, relax),
/// with the sizes of Dunyach et al. 2013.
Surface remesh(const Surface& fine, const BoxTree& boxes, const Eigen::VectorXd& wanted_m,
               double feature_angle_deg);

}  // namespace palpate
