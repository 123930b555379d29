#pragma once

#include <string_view>
#include <vector>

#include "tools/workshop/bench/ablated_surface.hpp"

namespace palpate::tools {

/// One way of computing forces over the 500-patch cylinder, and the clicks it makes.
struct ClickCase {
  std::string_view name;
  Ablation ablation;
  double scatter = 0;  ///< of the nodes' curves, see bench_cylinder
};
/// By how much curves must differ from node to node before facet curves click as the prototype's.
inline constexpr double kScatter = 0.28;
inline constexpr ClickCase kClickCases[] = {
    {"both interpolations", {}},
    {"facet normals", {false, true}},
    {"facet curves", {true, false}},
    {"neither", {false, false}},
    {"both, scattered nodes", {}, kScatter},
    {"facet normals, scattered nodes", {false, true}, kScatter},
    {"facet curves, scattered nodes", {true, false}, kScatter},
};

struct ClickResult {
  std::string_view name;
  int crossings = 0;         ///< ticks at which the contact point changed its triangle
  double median_jump_N = 0;  ///< of the force's change at those ticks
  double mean_jump_N = 0;
  double median_ridge_N =
      0;  ///< at those between facets at an angle: every other edge lies in a plane
  double p95_jump_N = 0, max_jump_N = 0;
  double ordinary_N = 0;   ///< median change at the other ticks
  double band_rms_N = 0;   ///< of the force's magnitude between 100 and 500 Hz
  double click_index = 0;  ///< that, over the first case's
};

/// The paper's experiment (its section 5): a tip slides at 50 mm/s over the cylinder at 1 kHz with
/// about 0.9 N, on `tracks` ways between around and along. A result per case.
std::vector<ClickResult> measure_clicks(int tracks);

}  // namespace palpate::tools
