#pragma once

#include <filesystem>
#include <string>

#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// Where simulated points are remembered, and what they must come from to be used again.
struct SimulateRequest {
  int jobs = 0;
  std::filesystem::path output;  ///< samples.h5; what is done is kept beside it until all is.
                                 ///< Empty: nothing is kept, nothing known
  std::string fingerprint;       ///< point_fingerprint of what is simulated
  bool resume = true;            ///< use what earlier runs simulated
};

/// Points that were simulated before: by an interrupted run (`OUTPUT.partial`), or for the samples
/// that OUTPUT holds now. A point is used again where its place, all that its rows come from and
/// whether it is dragged are the same; which other points there were does not matter.
class SampleCache {
 public:
  explicit SampleCache(const SimulateRequest& request);

  /// Experiments at the points, in parallel; those that are known are not simulated again. What is
  /// done is kept in `OUTPUT.partial`, rewritten at most every few seconds; an interruption
  /// (exception Interrupted) leaves it there. what: names the work in its progress. is_dragged: of
  /// each point; those that are not are pressed alone. Empty: all are, if any drag is wanted.
  Samples at(const fem::Simulator& simulator, const TestPoints& points,
             const fem::Experiments& experiments, const std::string& what,
             std::vector<char> is_dragged = {});

 private:
  Samples known_at(const TestPoints& points, int per_point,
                   const std::vector<char>& is_dragged) const;
  void keep(const Samples& samples) const;

  SimulateRequest request_;
  Samples interrupted_, earlier_;
};

/// Deletes what an unfinished simulate kept.
void remove_partial(const std::filesystem::path& output);

}  // namespace palpate::tools
