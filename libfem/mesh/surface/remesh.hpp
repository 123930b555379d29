#pragma once

#include "libfit/core/closest_point.hpp"

namespace palpate {

/// Wanted edge length at each vertex of a fine surface, #V [m]. boxes: triangle_boxes(fine).
/// The least of the target, the edge whose chord strays by 0.08 of the target on the local
/// curvature (sqrt(6 e r - 3 e^2), Dunyach et al. 2013, doi:10.2312/conf/EG2013/short/029-032), and
/// the local thickness, never below 0.4 of the target; then limited in growth from vertex to
/// vertex. Curvature finer than the target is smoothed away first: noise is not a feature.
Eigen::VectorXd wanted_edge_m(const Surface& fine, const BoxTree& boxes, double target_edge_m);

/// Lets no vertex's size exceed a neighbour's by more than half their distance.
void limit_growth(Eigen::VectorXd& size_m, const Surface& fine);

/// A surface with the shape of `fine` and edges of about `wanted_m` (#V, per fine vertex [m]),
/// vertices on `fine`, feature lines kept as edges.
/// fine: closed, manifold, outward. The result is closed and manifold; whether it crosses itself
/// or strays is for the caller to check. Deterministic.
/// Source: Botsch and Kobbelt 2004, doi:10.1145/1057432.1057457 (split, collapse, flip, relax),
/// with the sizes of Dunyach et al. 2013.
Surface remesh(const Surface& fine, const BoxTree& boxes, const Eigen::VectorXd& wanted_m);

}  // namespace palpate
