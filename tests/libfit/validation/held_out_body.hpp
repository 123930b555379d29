#pragma once

#include "libfit/core/body.hpp"
#include "libfit/experiments/draw.hpp"
#include "tests/support/bodies.hpp"

namespace palpate::validation {

using tools::bench_cylinder;
using tools::BenchAsset;
using tools::cylinder_stiffness_N_m;
using tools::kCylinderRadius_m;
using tools::make_bench_asset;

inline const HeldOutRange kRange{0.006, 0.004};

/// A cylinder of which one side between its ends can be reached.
inline Body cylinder_body() {
  Body body;
  body.surface = bench_cylinder(60, 40, 4).surface;
  for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v) {
    const double z = body.surface.vertices(v, 2);
    body.is_reachable.push_back(z > 0.02 && z < 0.08 && body.surface.vertices(v, 0) > 0);
  }
  return body;
}

}  // namespace palpate::validation
