#pragma once

#include "block.hpp"

// A rod that is pressed into the block, leaning.

namespace palpate::fem {

const Vec3 kRodInward = -Vec3::UnitZ();
constexpr double kRodRadius_m = 0.006, kRodEdge_m = 0.002, kRodDepth_m = 0.004;
constexpr int kRodRows = 8;

inline SimulationSetup rod_setup(double friction) {
  SimulationSetup setup = block_setup(friction);
  setup.probe = {};
  setup.probe.shape = "flat";
  setup.probe.values["radius"] = {kRodRadius_m};
  setup.probe.values["edge_radius"] = {kRodEdge_m};
  setup.probe.friction = friction;
  return setup;
}

inline PointRows press_rod(const Simulator& simulator, const Lean& lean) {
  ToolPath path;
  path.deflections.resize(kRodRows, 3);
  for (int i = 0; i < kRodRows; ++i)
    path.deflections.row(i) = kRodDepth_m * (i + 1) / kRodRows * kRodInward.transpose();
  path.lean = lean;
  return simulator.follow(block_top(), kRodInward, path);
}

}  // namespace palpate::fem
