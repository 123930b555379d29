#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

namespace palpate {

struct SimulationSurfaceOptions {
  /// Share of the fine volume; beyond it a finer target is tried. Grading bends the boundary of
  /// what is filled back onto the fine surface, which is why chords may lose this much volume.
  double volume_tolerance = 0.08;
  double stray_tolerance = 0.3;  ///< of target_edge_m: deviation beyond it, likewise
  /// #V of the fine surface, or empty [m]: how far each of its vertices may be from the coarse one.
  /// Edges near those that are farther are made shorter, round after round.
  Eigen::VectorXd allowed_m = {};
};

/// A coarse surface for the volume mesh, and how true it is.
struct SimulationSurface {
  Surface surface;           ///< closed, manifold, outward, free of self-intersection
  double target_edge_m = 0;  ///< the target that passed; 0 when `surface` is the fine one
  double deviation_m = 0;    ///< largest distance to the fine surface, both ways, sampled
  double excess = 0;         ///< largest distance of a vertex over what it is allowed; 0: not asked
  std::string refused;  ///< why earlier targets were, one sentence; empty when the first passed
};

/// A coarse surface of the body for filling: edges of about `target_edge_m` on flat, thick parts,
/// shorter where curvature or thinness asks, vertices on the fine surface, features kept.
/// fine: closed, manifold, outward. Every result has passed: closed and manifold, not crossing
/// itself, volume and deviation within tolerance. What crosses itself is tried again with shorter
/// edges there, what else fails with a finer target, at last with the fine surface itself.
/// Closeness to allowed_m is sought, not promised: `excess` is what was reached. Throws Error
/// when the target is not positive, when `fine` bounds no volume, or when even the fine one crosses
/// itself. Deterministic.
SimulationSurface simulation_surface(const Surface& fine, double target_edge_m,
                                     const SimulationSurfaceOptions& options = {});

}  // namespace palpate
