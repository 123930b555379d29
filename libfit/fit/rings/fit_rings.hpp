#pragma once

#include <array>
#include <vector>

#include "libfit/fit/rows/experiments.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/runtime/families/rings.hpp"

namespace palpate::fit {

/// What is known of a body's rings beforehand and how surely. Friction slopes in 1 / the unit of
/// length.
struct RingPrior {
  double lambda = 2.0 / 3.0, friction = 0.3, friction_slope = 0;
  double lambda_deviation = 0.2, friction_deviation = 0.03, friction_slope_deviation = 0;
};
/// By theory: lambda = 2 (1 - nu) / (2 - nu) of a half-space, mu(d) = 0.95 mu (1 + d / 2R) of a
/// ball that ploughs. radius_m 0: no slope.
RingPrior ring_prior(double poisson, double probe_friction, double probe_radius_m, double length_m);

/// Numbers of a point beside f^z, in units of the body's length and the point's force.
struct RingNumbers {
  double lambda = 0, friction = 0, friction_slope = 0;
  Eigen::Vector4d side = Eigen::Vector4d::Zero();  ///< g_2, g_3 along tangents_of(inward)
  Eigen::VectorXd increments;                      ///< of f^z
  double relative_residual = 0;                    ///< rms difference over rms force
  int slid_rows = 0;
};

/// As runtime reads them, curvature included.
std::array<double, runtime::kRingNumbers> ring_numbers(const PointData& point,
                                                       const RingNumbers& of);

/// f^z, lambda, mu_0, mu_1 and g of a point jointly, by replaying all its experiments through the
/// law. g starts from the presses' own lateral force, f^z from `increments`; faint: what decides of
/// f^z where rows are silent.
RingNumbers fit_rings(const PointData& point, const runtime::SplineView& basis, const Faint& faint,
                      const Eigen::VectorXd& increments, const RingPrior& prior, FitLoss loss);

/// Medians of the body's points as the prior of a second pass; slopes and deviations as before.
RingPrior ring_medians(const std::vector<RingNumbers>& points, const RingPrior& before);

}  // namespace palpate::fit
