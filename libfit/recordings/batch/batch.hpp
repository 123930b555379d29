#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/progress.hpp"
#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/batch/registration.hpp"
#include "libfit/recordings/formats/recording.hpp"

namespace palpate::recordings {

/// One file of a manifest with all that is said about it.
struct BatchItem {
  std::filesystem::path file;
  std::string shown;               ///< the file as the manifest names it
  std::string place;               ///< "manifest.toml:12:1", for errors about the entry itself
  std::string point;               ///< name of the test point; empty: the file's own name
  std::optional<Vec3> position_m;  ///< of the point, in the body's frame
  std::optional<Vec3> normal;      ///< inward unit, in the body's frame
  importers::ReadSettings read;
  SignalSettings signal;
};

/// Name of the point that a recording of a file is of, by its name there: recordings of one point
/// are repeats.
std::string point_of(const BatchItem& item, const std::string& recording);

/// Why a recording gave nothing: the parts of an Error.
struct Failure {
  std::string where, what, remedy;
};

/// A recording that gave nothing.
struct Refused {
  std::string name;  ///< within its file; empty of a whole file
  Failure failure;
  SignalTrace trace;  ///< as far as it is known
};

/// The recordings of an item, and those that were refused.
struct ItemResult {
  std::string hash;  ///< ContentHash of the file's bytes; empty when they could not be read
  std::vector<Conditioned> recordings;
  std::vector<Refused> refused;
  bool is_done = false;  ///< else the batch was stopped before
};

struct BatchOptions {
  int jobs = 0;  ///< threads, 0: all. Results do not depend on it
  /// Brings the rig's frame to the body's.
  RigidMotion body_from_rig = {};
  const Surface* surface = nullptr;  ///< of the body; null: unknown
  bool fits_to_surface = false;      ///< the motion is refined by contact points (AssembleOptions)
};

/// Reads and conditions every item, in parallel; a bad one becomes a failure and stops nothing.
/// Recordings whose contact the surface says better than they do are conditioned a second time,
/// with it. Returns a result per item, in their order. Stops early, with items not done, when
/// Progress says so.
std::vector<ItemResult> run_batch(const std::vector<BatchItem>& items, const BatchOptions& options,
                                  const Progress& progress);

}  // namespace palpate::recordings
