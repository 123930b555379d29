#pragma once

#include "libfit/core/closest_point.hpp"

namespace palpate {

/// What an edge of the simulation surface may be, before its local limits.
struct SizingOptions {
  double target_edge_m = 0;       ///< on flat, thick parts; > 0
  double deviation_ratio = 0.08;  ///< of target_edge_m: how far a triangle may stray from a curve
  double thickness_ratio = 1.0;   ///< edge over local thickness, so that tets fit in thin parts
  double min_edge_ratio = 0.4;    ///< of target_edge_m: never shorter than this
  double growth = 0.5;            ///< of size per distance along the surface
  double feature_angle_deg = 60;  ///< sharper edges are features: curvature stops at them
};

/// Wanted edge length at each vertex of a fine surface, #V [m]. boxes: triangle_boxes(fine).
/// The least of the target, the edge whose chord strays by the allowed deviation on the local
/// curvature (sqrt(6 e r - 3 e^2), Dunyach et al. 2013, doi:10.2312/conf/EG2013/short/029-032), and
/// the local thickness, never below the least edge; then limited in growth from vertex to vertex.
/// Curvature finer than the target is smoothed away first: noise is not a feature.
Eigen::VectorXd wanted_edge_m(const Surface& fine, const BoxTree& boxes,
                              const SizingOptions& options);

/// Lets no vertex's size exceed a neighbour's by more than growth times their distance.
void limit_growth(Eigen::VectorXd& size_m, const Surface& fine, double growth);

}  // namespace palpate
