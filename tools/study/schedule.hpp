#pragma once

#include <string>
#include <vector>

#include "tools/study/work.hpp"

namespace palpate::tools {

/// A scheduler's array: one kind of work, cut into tasks about as long as [cluster] says.
struct WorkArray {
  WorkKind kind = WorkKind::prepare;
  std::vector<std::vector<Work>> tasks;
  double longest_s = 0;  ///< expected time of the longest task
  double most_MB = 0;    ///< expected memory of the largest work
};

/// All that is missing and not among `active`, one array a kind, each needing those before it.
std::vector<WorkArray> arrays_of(const StudyFolder& study, const std::vector<std::string>& active);

/// Where tasks are listed, a line each: DIR/jobs/003-simulate.txt.
std::filesystem::path write_list(const StudyFolder& study, const WorkArray& array);

/// Does a line (from 1) of such a list; the next work where one fails. Returns how many failed.
int do_task(const StudyFolder& study, const std::filesystem::path& list, int line, int jobs);

/// All that is missing, here, in order. Returns how many works failed.
int do_all(const StudyFolder& study, int jobs);

/// What any scheduler would run: its commands, with what must be done before each array.
std::string script_of(const StudyFolder& study);

/// Tasks of the study that Slurm has.
struct SlurmQueue {
  int running = 0, pending = 0;
  std::vector<std::string> active;  ///< texts of their works
};
/// None where nothing was submitted. Throws Error where Slurm does not answer.
SlurmQueue queue_of(const StudyFolder& study);
bool was_submitted(const StudyFolder& study);

/// Submits what is missing and not in the queue: an array a kind, each after the one before it.
/// only_rounds: only if a round of a placement has ended since the last time. Returns the number of
/// tasks. Throws Error where there is no Slurm, or it refuses.
int submit(const StudyFolder& study, bool only_rounds = false);

}  // namespace palpate::tools
