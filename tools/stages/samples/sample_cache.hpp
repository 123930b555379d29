#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/io/files/files.hpp"

namespace palpate::tools {

/// The file that remembers simulated points, and the fingerprints they need to be used again.
struct SimulateRequest {
  int jobs = 0;
  std::filesystem::path output;      ///< samples.h5; what is done is kept beside it until all is.
                                     ///< Empty: nothing is kept, nothing known
  std::string fingerprint;           ///< point_fingerprint of what is simulated
  std::string tool;                  ///< tool_fingerprint of the scene's other tools; empty: none
  bool resume = true;                ///< use what earlier runs simulated
  Eigen::Index surface_columns = 0;  ///< of all that is known and simulated; 0: not wanted
  bool only_known = false;           ///< simulate nothing: throw PointsMissing
};

/// Experiments, and what presses on one mesh lack.
struct ExperimentBatch {
  ExperimentList list;
  fem::QuickScale quick;
};

/// Thrown where SimulateRequest::only_known is set and experiments are not known: these.
struct ExperimentsMissing {
  ExperimentBatch batch;
};

/// Keeps what is done at once, and then no oftener than that a fiftieth of the time goes into it.
class KeepClock {
 public:
  void keep(const std::function<void()>& write);

 private:
  double next_s_ = 0;
};

/// Experiments that were simulated before: by an interrupted run (`OUTPUT.partial`), or for the
/// samples that OUTPUT holds now. One is used again where it is the same (known_rows) and all that
/// its rows come from is; which others there were does not matter.
class SampleCache {
 public:
  explicit SampleCache(const SimulateRequest& request);
  /// Knows these as well, of any points.
  SampleCache(const SimulateRequest& request, Samples known);

  /// Experiments of a list, in parallel; those that are known are not simulated again. What is done
  /// is kept in `OUTPUT.partial`, rewritten whenever one is finished, but for a fiftieth of the
  /// time at most; an interruption (exception Interrupted) leaves it there. what: names the work in
  /// its progress. quick: what presses on one mesh lack.
  Samples at(const fem::SimulatorOf& simulator, const ExperimentList& list,
             const fem::Experiments& each, const std::string& what,
             const fem::QuickScale& quick = {});

 private:
  Samples read_known(const std::filesystem::path& path) const;
  void keep(const Samples& samples) const;

  SimulateRequest request_;
  Samples interrupted_, earlier_;
  KeepClock clock_;
};

/// Attributes by which samples are known again.
Attributes attributes_of(const SimulateRequest& request);

/// Samples with what is known of their surface beside them (surface_path), each whole or not at
/// all; a file of another surface is removed. The surface goes first: it is never older.
void write_with_surface(const std::filesystem::path& path, const Samples& samples,
                        const Attributes& attributes);
/// Samples with the motion of their surface. Throws Error where either is missing or damaged.
Samples read_with_surface(const std::filesystem::path& path);

/// Deletes what an unfinished simulate kept.
void remove_partial(const std::filesystem::path& output);

}  // namespace palpate::tools
