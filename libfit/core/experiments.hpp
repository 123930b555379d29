#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"

namespace palpate {

/// One thing that is done to a body. Of the kind press: what Experiments say of a test point, the
/// press and, if it is dragged, the drags; of all others: its path, whose point is the place.
struct Experiment {
  ExperimentKind kind = ExperimentKind::press;
  std::int32_t place = 0;
  Effort effort = {};
  ToolPath path = {};
  std::int32_t probe_number = 0;  ///< of Samples
};

/// Experiments on a body, in order, and their places.
struct ExperimentList {
  TestPoints places;
  std::vector<Experiment> experiments;

  std::size_t size() const { return experiments.size(); }
};

/// Presses, and drags where they are wanted, at every point. effort: of each; empty: all dragged.
ExperimentList experiments_at(const TestPoints& points, const std::vector<Effort>& effort = {});
/// Paths of one kind at their points; of two tools the places of the second ones come after those.
/// Throws Error where a path names a point that does not exist.
ExperimentList paths_at(const TestPoints& points, const std::vector<ToolPath>& paths,
                        ExperimentKind kind = ExperimentKind::path, std::int32_t probe_number = 0);
/// Appends experiments with their places. A place that is there already is not put in twice.
void append(ExperimentList& to, const ExperimentList& more);
/// Those of a list, by their numbers, with their places alone.
ExperimentList taken(const ExperimentList& list, const std::vector<std::size_t>& which);

/// The experiments of a list as samples: placeholder rows, whose status is not_reached. A press has
/// one row, and one more if it is dragged; its scale is that of its place.
Samples planned_rows(const ExperimentList& list);
/// The list that rows were planned for.
ExperimentList list_of(const Samples& planned);

/// First number of Samples::experiment that each one takes. per_point: of a
/// press with all its drags.
std::vector<std::int32_t> first_numbers(const ExperimentList& list, int per_point);

/// Results in `known` for the wanted experiments, in their order and with their numbers, at all of
/// their places. Experiments are compared bit by bit: kind, place, normal, effort, and of a path
/// every deflection, time and lean of every tool. The first of several equal ones counts.
Samples known_rows(const ExperimentList& wanted, const Samples& known, int per_point);

/// Experiments without a row in samples that are theirs, ascending.
std::vector<std::size_t> without_rows(const ExperimentList& list, const Samples& samples,
                                      int per_point);

/// The experiments of samples that are not in the list, as known_rows() would find them.
Samples beyond(const Samples& samples, const ExperimentList& list);

}  // namespace palpate
