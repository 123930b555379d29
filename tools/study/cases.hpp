#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/scene/key_log.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// One case of a study: a scene, and the words by which the study names it.
struct StudyCase {
  std::string name;  ///< 12 hex digits of its scene's text and the program: its folder's name
  std::vector<std::string> inputs;  ///< as Study::inputs names them
  std::string scene;                ///< text of its scene.toml, files by absolute names
  int body = 0;                     ///< cases of one number share the prepared body
  /// The case whose samples are this one's but for a factor of all forces; itself where it is
  /// simulated.
  int source = 0;
  double factor = 1;  ///< its forces over those of its source
};

/// What [cluster] says.
struct ClusterSection {
  std::string command;               ///< instead of this program, as a container starts it
  std::vector<std::string> options;  ///< further options of sbatch
};

/// A study.toml with its cases (docs/formats/study.md).
struct Study {
  std::filesystem::path path;
  std::vector<std::string> inputs;  ///< columns: body, material, probe, and the keys varied
  std::vector<StudyCase> cases;
  ClusterSection cluster;
};

/// Reads a study and makes its cases: all combinations of bodies, materials, probes, lists and
/// ranges; or ranges sampled together by a Sobol sequence or a Latin hypercube; or the rows of a
/// table. Every scene is checked as `check` does without its mesh. Throws Error with the place in
/// the study or, of a case's scene, with the words that name the case.
Study read_study(const std::filesystem::path& path, KeyLog* log = nullptr);

}  // namespace palpate::tools
