#pragma once

#include <algorithm>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/law/families.hpp"

namespace palpate {

/// What people are shown of the nodes of a curve set, whatever its family. The set must outlive it.
class NodeForces {
 public:
  explicit NodeForces(const CurveSet& curves) : curves_(curves) {
    for (std::size_t kind = 0; kind < curves_of(curves.family); ++kind)
      tables_.push_back(tabulate(curves.basis[kind]));
  }

  double normal_N(Eigen::Index row, double depth_m) const {
    return runtime::curve_value(view(CurveKind::normal), of(CurveKind::normal, row), depth_m);
  }
  double normal_slope_N_m(Eigen::Index row, double depth_m) const {
    return runtime::curve_slope(view(CurveKind::normal), of(CurveKind::normal, row), depth_m);
  }
  /// Lateral force at which a tool slides: L(d), or mu(d) f^z(d) of rings.
  double limit_N(Eigen::Index row, double depth_m) const {
    if (tables_.size() == kCurveKinds)
      return runtime::curve_value(view(CurveKind::limit), of(CurveKind::limit, row), depth_m);
    const double mu = curves_.control[runtime::kFriction](row, 0) +
                      curves_.control[runtime::kFrictionSlope](row, 0) * depth_m;
    return std::max(mu, 0.0) * normal_N(row, depth_m);
  }
  /// Lateral stiffness of a tool pressed straight to a depth.
  double lateral_slope_N_m(Eigen::Index row, double depth_m) const {
    if (tables_.size() == kCurveKinds)
      return runtime::curve_slope(view(CurveKind::lateral), of(CurveKind::lateral, row), 0);
    return curves_.control[runtime::kLambda](row, 0) * normal_slope_N_m(row, depth_m);
  }

 private:
  runtime::SplineView view(CurveKind kind) const {
    return palpate::view(tables_[static_cast<std::size_t>(kind)]);
  }
  const double* of(CurveKind kind, Eigen::Index row) const {
    return curves_.control[static_cast<std::size_t>(kind)].row(row).data();
  }

  const CurveSet& curves_;
  std::vector<SplineTables> tables_;
};

}  // namespace palpate
