#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"

namespace palpate::recordings {

/// A body's relaxation by its recordings (method-recordings.md, section 25).
struct BodyRelaxation {
  RelaxationFit fit;  ///< of all recordings that were used; no branches where they show none
  struct PointSeries {
    std::string name;
    RelaxationFit fit;  ///< with as many branches as the body's
  };
  std::vector<PointSeries> points;  ///< those with a hold, where there are several
  struct Used {
    std::string file, point;
  };
  std::vector<Used> recordings;
  bool has_holds = false;  ///< else several rates alone
  /// Why rows in time would be worse than a mean of repeats: a phrase each.
  std::vector<std::string> doubts;
  bool is_applied = false;  ///< else proposed alone: samples do not have it
};

/// A recording that goes into the samples, or one that was refused.
struct PlacedRecording {
  const BatchItem* item = nullptr;         ///< of the batch
  const ItemResult* result = nullptr;      ///< its
  const Conditioned* recording = nullptr;  ///< of the results; null: refused before it had rows
  const Refused* refused = nullptr;        ///< of the results, then
  std::string name = {};                   ///< within its file
  std::string point = {};
  Vec3 position_m = Vec3::Zero();  ///< on the body
  Vec3 inward = Vec3::UnitZ();
  Mat3 to_body = Mat3::Identity();  ///< turns its deflections and forces into the body's frame
  /// NaN without a surface.
  double surface_distance_m = kNan;
  std::int32_t experiment = -1;  ///< -1: refused
  std::optional<Error> failure = {};
};

/// Recordings of one point.
using Members = std::vector<PlacedRecording*>;

/// "file.csv" or "file.csv#name".
std::string shown(const PlacedRecording& placed);

struct Assembled {
  Samples samples;
  /// That of most recordings first: curves are of it, and rows of the others of the kind `other`,
  /// with their number here as Samples::probe_number. None where no radius is known.
  std::vector<UsedTip> tips;
  std::size_t files = 0;
  /// Every recording and every item without any, in order. Refers to items and results.
  std::vector<PlacedRecording> outcomes;
  std::optional<Registration> registration;
  /// Where recordings have holds or rates. Where it is applied, samples have rows in time, and each
  /// recording is an experiment of its own.
  std::optional<BodyRelaxation> relaxation;
  std::vector<std::string> notes;  ///< on recordings, a sentence each

  std::size_t failed() const;
};

/// Places, checks against each other, pools and numbers the recordings of a batch. Refused are
/// recordings too far from the surface or from the position that the manifest names, without a
/// place or normal, and those whose stiffness is implausible, or a prefix away from the others of
/// the batch. results: one per item. Throws Error when a registration is impossible.
Assembled assemble(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const BatchOptions& options);

/// Writes what became of every recording, whole or not at all: CSV with a row each
/// (file,line,point,status,grade,reason,remedy,...), and JSON with the same and the totals. The
/// same batch gives the same bytes, however it was interrupted.
void write_summary(const std::filesystem::path& csv, const std::filesystem::path& json,
                   const Assembled& assembled);

/// The totals and notes alone, with the refused recordings, as one JSON object for stdout.
std::string summary_json(const Assembled& assembled);

/// Every recording with the signal that a picture is drawn from, in the order of the outcomes.
RecordedSignals signals_of(const Assembled& assembled);
/// Those that samples were made from.
MeasuredRecordings provenance(const std::vector<PlacedRecording>& outcomes);

// Steps of `assemble`.

inline constexpr double kSameRate = 1.25;  ///< repeats differ by less; a series of rates by more

inline UsedTip tip_of(const PlacedRecording& c) { return c.item->signal; }

/// Finds place and inward normal of each candidate; refuses those that have none or lie elsewhere.
std::optional<Registration> place_on_body(const BatchOptions& options,
                                          std::vector<PlacedRecording>& candidates);

/// One experiment of the samples, in the body's frame.
struct Pooled : ExperimentRows {
  Members member;
  double speed_m_s = 0;
  std::int32_t point = 0, experiment = 0, probe = 0;
  ExperimentKind kind = ExperimentKind::press;
};

/// A recording's rows in the body's frame.
Pooled on_body(PlacedRecording& recording);

/// Experiments of one point: presses at one rate are one. members: none of them refused.
std::vector<Pooled> pool(const Members& members);

/// Effects of rates and unloading beyond the noise, a sentence each; empty when none stands out.
std::vector<std::string> compare_rates(const std::string& point,
                                       const std::vector<Pooled>& experiments);

/// Relaxation of a body, and of each of its points that has a hold, from presses that show how it
/// changes in time: with a stand in contact, or of one point at several rates; of those that show
/// most, as few as a search can take. Nothing where none does.
std::optional<BodyRelaxation> relaxation_of(const std::vector<Members>& points);

/// The relaxation that was identified, in words.
std::vector<std::string> relaxation_notes(const BodyRelaxation& found);

/// Rows of a recording in time, from first to last touch of its deepest press; those of a drag or
/// path by its path. Nothing without a clock.
std::optional<Pooled> in_time(PlacedRecording& recording);

}  // namespace palpate::recordings
