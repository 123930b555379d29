#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/scene/key_log.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

/// One case of a study: a scene, and the words by which the study names it.
struct StudyCase {
  std::string name;  ///< 12 hex digits of its scene's text and the program: its folder's name
  std::vector<std::string> inputs;  ///< as Study::inputs names them
  std::string scene;                ///< text of its scene.toml, files by absolute names
  int body = 0;                     ///< cases of one number share the prepared body
};

/// Contents of [cluster].
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

/// Reads a study and makes its cases: all combinations of bodies, materials, probes and lists, or
/// the rows of a table. Every scene is
/// checked as `check` does without its mesh. Throws Error with the place in the study or, of a
/// case's scene, with the words that name the case.
Study read_study(const std::filesystem::path& path, KeyLog* log = nullptr);

enum class CaseState { done, failed, partly, waiting };
inline constexpr std::array<std::string_view, 4> kCaseStateNames{"done", "failed", "partly",
                                                                 "waiting"};

/// The folder of a study (docs/formats/study.md). What is done is told by the files that are there,
/// each whole or not at all, so that any number of processes on any number of machines can work in
/// it.
class StudyFolder {
 public:
  /// Writes the study's plan and scenes. Results of cases that were there already are kept.
  static void plan(const std::filesystem::path& folder, const Study& study);
  /// Throws Error where the folder holds no study, or one planned by another version.
  explicit StudyFolder(const std::filesystem::path& folder);

  /// Numbers of the cases that are not done.
  std::vector<int> missing() const;
  /// Does a case that is not done. An Error is kept in the case's error.txt and said.
  void run_case(int number, int jobs) const;

  CaseState state(int number) const;
  /// Why a case failed, in one line; empty where it did not.
  std::string failure(int number) const;
  /// Forgets failures, so that what failed is tried again.
  void forget_failures() const;
  /// results.csv: a row a case, with inputs, state, error statement, stiffness, cost.
  void write_results() const;

  std::filesystem::path case_folder(int number) const;
  const std::filesystem::path& path() const { return path_; }
  const std::vector<StudyCase>& cases() const { return study_.cases; }
  const ClusterSection& cluster() const { return study_.cluster; }

 private:
  void share_body(int number) const;

  std::filesystem::path path_;
  Study study_;
};

constexpr int kMaxCases = 1000000;  ///< of a study: each is a file of a few kB

/// A value on an axis of a study, and what it changes in a scene.
struct CaseChange {
  std::vector<std::string> words;                            ///< one a column
  std::vector<std::pair<std::string, toml::table>> changes;  ///< dotted key; table: {"value": v}
  std::string replaced;                                      ///< a section that is emptied first
};
using Axis = std::vector<CaseChange>;

/// Axes of a study: its cases are all combinations of one value of each axis.
struct Axes {
  std::vector<Axis> axis;
  std::vector<std::string> inputs;  ///< columns: body, material, probe, and the keys varied
};

/// Reads [bodies.*], [materials.*], [probes.*] and [vary] of a study
/// (docs/formats/study.md). file: as errors name it. Throws Error with the place of what is wrong.
Axes read_axes(SceneTable& top, const std::string& file);

}  // namespace palpate::tools
