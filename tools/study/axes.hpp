#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

constexpr int kMaxCases = 1000000;  ///< of a study: each is a file of a few kB

/// A value on an axis of a study, and what it changes in a scene.
struct CaseChange {
  std::vector<std::string> words;  ///< one a column; several of ranges sampled together
  std::vector<std::pair<std::string, toml::table>> changes;  ///< dotted key; table: {"value": v}
  std::string replaced;                                      ///< a section that is emptied first
};
using Axis = std::vector<CaseChange>;

/// Axes of a study: its cases are all combinations of one value of each axis.
struct Axes {
  std::vector<Axis> axis;
  std::vector<std::string> inputs;  ///< columns: body, material, probe, and the keys varied
};

/// Reads [bodies.*], [materials.*], [probes.*], [vary] and [sample] of a study
/// (docs/formats/study.md). file: as errors name it. Throws Error with the place of what is wrong.
Axes read_axes(SceneTable& top, const std::string& file);

}  // namespace palpate::tools
