#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/stages/samples/shards.hpp"
#include "tools/study/cases.hpp"

namespace palpate::tools {

/// What is done for a study, in the order in which one needs the other.
enum class WorkKind { prepare, simulate, merge, finish };
inline constexpr std::array<std::string_view, 4> kWorkNames{"prepare", "simulate", "merge",
                                                            "finish"};

/// One thing to do: a body for all its cases, a shard of a case, its merge, or the stages after it.
struct Work {
  WorkKind kind = WorkKind::prepare;
  int item = 0;  ///< the body's number, or the case's
  Shard shard = {};

  std::string text() const;  ///< "simulate:12:3/8"
  static Work parse(const std::string& text);
};

/// What a pilot measured on one processor, or the study said.
struct StudyCost {
  double prepare_s = 0;   ///< of the pilot's body
  double point_s = 0;     ///< of a test point
  int points = 0;         ///< of the pilot's case
  double memory_MB = 0;   ///< of one point at a time
  double surface_MB = 0;  ///< of how the surface moves in a point's rows, once
};

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

  /// Work that is not done, in the order of cases.
  std::vector<Work> missing(WorkKind kind) const;
  /// Expected processor seconds.
  double expected_s(const Work& work) const;
  /// Expected memory: the pilot's, and what is kept of all points.
  double expected_MB(const Work& work) const;
  /// Does it, unless it is done. An Error is kept in error.txt of the cases that it stops, and
  /// said; returns whether there was none.
  bool work(const Work& work, int jobs) const;

  CaseState state(int number) const;
  /// Why a case failed, in one line; empty where it did not.
  std::string failure(int number) const;
  /// Forgets failures, so that what failed is tried again.
  void forget_failures() const;
  /// results.csv and results.h5: a row a case, with inputs, state, error statement, stiffness,
  /// cost.
  void write_results() const;

  /// Measures the case of the largest mesh, unless the study says its cost or it was measured.
  void measure();

  /// Whether points of a case place themselves, and how far all such cases are: grows with each
  /// round of one.
  bool has_rounds() const { return has_rounds_; }
  int rounds() const;

  std::filesystem::path case_folder(int number) const;
  const std::filesystem::path& path() const { return path_; }
  const std::vector<StudyCase>& cases() const { return study_.cases; }
  const ClusterSection& cluster() const { return study_.cluster; }
  const StudyCost& cost() const { return cost_; }

 private:
  void prepare(int body) const;
  void merge(int number, int jobs) const;
  void finish(int number, int jobs) const;
  std::vector<int> cases_of(const Work& work) const;
  int round_points(int number) const;
  int shards(int number) const;

  std::filesystem::path path_;
  Study study_;
  StudyCost cost_;
  bool has_rounds_ = false;
  /// Of each case: test points at first, where known, and at most; and those of validation.
  std::vector<int> points_, max_points_, held_out_;
};

/// The samples of a body whose moduli are `factor` times as large.
Samples with_forces_times(Samples samples, double factor);

}  // namespace palpate::tools
