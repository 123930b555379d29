#pragma once

#include <functional>
#include <vector>

#include "libfem/solve/experiments/quick_press.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// jobs: threads, 0 for one per processor. already_done: rows of an earlier run on the same points;
/// a point that has rows there keeps them and is not simulated again.
/// effort: of each test point; empty: all are dragged. quick: what presses on one mesh lack; none:
/// they are left as they are.
struct SimulateOptions {
  int jobs = 0;
  Samples already_done;
  std::vector<Effort> effort = {};
  QuickScale quick = {};
};

/// Called when a test point (or a path) is finished, one call at a time. `so_far` gathers all that
/// is finished, as a later run takes it in `already_done`.
using OnePointDone = std::function<void(const std::function<Samples()>& so_far)>;

/// Experiments at every test point, in parallel over points; rows in point order, the same bits
/// whatever the number of threads. Stops early on progress.stopped(): the result then holds the
/// finished points only. Callers check_experiments first; a point that is thinner than the press is
/// deep is tried all the same, and its rows say how far it went.
Samples simulate(const Simulator& simulator, const TestPoints& points,
                 const Experiments& experiments, const SimulateOptions& options = {},
                 const OnePointDone& on_done = {}, const Progress& progress = {});

/// Tool paths at test points: one experiment of kind `path` each, numbered in the order given.
/// options.already_done counts paths by their experiment number.
Samples simulate_paths(const Simulator& simulator, const TestPoints& points,
                       const std::vector<ToolPath>& paths, const SimulateOptions& options = {},
                       const OnePointDone& on_done = {}, const Progress& progress = {});

}  // namespace palpate::fem
