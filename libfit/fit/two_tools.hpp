#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// Forces on the body of both tools at rows of paths of two tools, row for row.
struct TwoToolForces {
  Points first_N, second_N;
  std::size_t ticks = 0;  ///< of both
};

/// The engine's answers at the rows of `samples`, whose experiments are numbers of `paths` (all of
/// two tools): both tips come from a tenth of depth_m outside and move by 20 um a tick at most.
/// coupling: what they feel each other by, in place of the asset's; none: each is by itself.
TwoToolForces replay_two_tools(const runtime::AssetView& asset,
                               const runtime::CouplingView& coupling, const Samples& samples,
                               const std::vector<ToolPath>& paths, double depth_m);

/// Forces of good rows, both tools', against the engine's: relative to the force, or to a tenth of
/// the tool's largest in its experiment where that is more.
std::vector<double> two_tool_errors(const Samples& samples, const TwoToolForces& answered);

/// Those errors in coordinates, six a row: least squares of them tell the coupling.
Eigen::VectorXd two_tool_residual(const Samples& samples, const TwoToolForces& answered);

}  // namespace palpate
