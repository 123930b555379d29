#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/runtime/tool/tool.hpp"

namespace palpate {

/// Paths of a rigid tool; of each, the balls that it is played as and how it stands.
struct CompoundPaths {
  std::vector<ToolPath> paths;
  std::vector<runtime::ToolShape> shape;
  std::vector<Stance> stance;
};

/// The engine's answers at rows of such paths: force on the body, and torque on it about the tool's
/// reference point, row for row.
struct CompoundForces {
  Points force_N, torque_Nm;
  std::size_t ticks = 0;  ///< of the whole tool
};

/// Follows the rows of `samples`, whose experiments are numbers of the paths: the tool comes from a
/// tenth of depth_m outside and its reference point moves by 20 um a tick at most. coupling: by
/// which its contacts feel each other, in place of the asset's; none: each is by itself.
CompoundForces replay_compound(const runtime::AssetView& asset,
                               const runtime::CouplingView& coupling, const CompoundPaths& tool,
                               const Samples& samples, double depth_m);

/// Forces and torques of good rows less the reference's, six numbers a row; forces over the
/// reference's, or a tenth of the largest of its experiment where that is more, torques over the
/// same force at the lever of the tool's balls.
Eigen::VectorXd compound_residual(const CompoundPaths& tool, const Samples& samples,
                                  const CompoundForces& answered);

}  // namespace palpate
