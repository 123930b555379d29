#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// Forces on the body of both tools at rows of paths of two tools, row for row.
struct TwoToolForces {
  Points first_N, second_N;
  double tick_ns = 0;  ///< mean wall time of a tick of both
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

/// Errors without coupling, and with what was identified. scaled: what all of it was multiplied by
/// to stay below the contacts' own compliance.
struct CouplingReport {
  std::size_t pairs = 0, rows = 0;
  double median_alone = 0, p95_alone = 0, median = 0, p95 = 0;
  double scaled = 1;
};

/// How tools feel each other (M62), from paths of two tools on the asset's body, which must be of
/// rings that neither relax, soften nor sway: least squares of the errors over the a_k and b_k of
/// scales length_m 2^k, none negative, with the engine in the loop. None where it does not take a
/// tenth off the error without.
runtime::CouplingView identify_coupling(const runtime::AssetView& asset, const Samples& samples,
                                        const std::vector<ToolPath>& paths, double depth_m,
                                        double length_m, CouplingReport* report = nullptr);

}  // namespace palpate
