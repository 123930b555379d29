#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/model.hpp"

namespace palpate::tools {

/// Files that stages read and write. A stage leaves out what has no name.
struct StageFiles {
  std::filesystem::path body = {}, samples = {}, curves = {}, model = {}, asset = {},
                        statement = {};
  std::filesystem::path engine = {};     ///< folder that export copies the engine into
  std::filesystem::path rows = {};       ///< rows that validate compares
  std::filesystem::path reference = {};  ///< folder that keeps what validate simulates
};

/// The names that they have in the folder of a run.
StageFiles files_in(const std::filesystem::path& folder);

/// State that the stages of one body share. A scene's stages read `scene`, those of recordings
/// `import`, and `fit` is of either.
struct Pipeline {
  StageFiles files = {};
  int jobs = 0;        ///< threads, 0 for all cores
  bool resume = true;  ///< use what earlier runs simulated
  Scene scene = {};
  FitSection fit = {};
  Body body = {};             ///< from `prepare` on
  bool surface_only = false;  ///< of `prepare`: without a volume
  /// Called before the first file is written, when the inputs have been checked.
  std::function<void()> before_writing = {};
  ImportRequest import = {};
  FitOptions fit_choices = {};  ///< of fit_samples(), and where its cache goes
  ModelChanges changes = {};    ///< of an exported model
  Samples samples = {};         ///< simulated, until `say` has reported them

  // What stages find, for the reply of a command. bad_experiments: also recordings refused.
  std::optional<std::size_t> bad_experiments = {};
  nlohmann::ordered_json imported = {};
  ExportReport exported = {};
  validation::Statement statement = {};
};

/// A stage: one file, what it is made of, and how. `run` goes through a list of them; the command
/// of a stage takes its row, on files of its own.
struct StageRow {
  const char* name;
  const char* summary;  ///< one line of the log is of all neighbours with the same
  std::filesystem::path StageFiles::*output;
  /// Fingerprint of everything that the output depends on.
  std::string (*wanted)(const Pipeline&);
  /// Writes the output with that fingerprint; an empty one is not written.
  void (*make)(Pipeline&, const std::string& fingerprint);
  /// Fingerprint of the output that is there; nothing where a file of the stage is missing. Null:
  /// the one that the output has as an HDF5 file.
  std::optional<std::string> (*stored)(const Pipeline&) = nullptr;
  /// Reports on stderr what was made; null: nothing more than `make` does.
  void (*say)(Pipeline&) = nullptr;
  /// Reads what later stages need of an output that is up to date; null: they read the file.
  void (*load)(Pipeline&, const std::string& fingerprint) = nullptr;
};

extern const StageRow kPrepareStage, kSimulateStage, kFitStage, kRefineStage, kExportStage,
    kValidateStage;
/// The first ones and the last of recordings; fit, refine and export are the same.
extern const StageRow kImportStage, kRecordedBodyStage, kRecordedValidateStage;

/// The stages from a scene, and from a manifest, to the statement.
std::vector<const StageRow*> stages_of_scene();
std::vector<const StageRow*> stages_of_recordings();

/// Makes a stage's output anew, with its fingerprint.
void remake(const StageRow& stage, Pipeline& pipeline);

/// Refuses what a later stage of the scene would refuse: no [material], a probe, pairs of tools or
/// a [tool] that the simulator or the engine does not know. Throws Error with a remedy.
void check_choices(const Scene& scene);

class RunLog;

/// Input of `palpate run`. scene: or a manifest. jobs: threads, 0 for all cores.
struct RunRequest {
  std::string scene, folder;
  int jobs = 0;
  bool force = false, quick = false;
};

inline constexpr const char* kRunLog = "run.log";

struct RunResult {
  int stages_done = 0;
  std::size_t items_failed = 0;  ///< experiments, points, held-out rows; each is said
  validation::Statement statement;
};

/// All stages from a scene or a manifest of recordings to an asset and its statement, those that
/// are up to date left out (docs/formats/run.md). Keeps a second run out of the folder. log: opened
/// in the folder as kRunLog; a line a stage stays on stderr.
RunResult run(const RunRequest& request, RunLog* log = nullptr);

}  // namespace palpate::tools
