#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/batch/registration.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"

namespace palpate::recordings {

/// What becomes of a body's relaxation that recordings tell.
enum class RelaxationUse { none, where_sure, always };

/// What turns the results of a batch into samples on a body.
struct AssembleOptions {
  const Surface* surface = nullptr;   ///< positions are projected onto it
  std::optional<RigidMotion> motion;  ///< rig to body, where it is known
  bool fits_to_surface = false;       ///< refine it by the contact points
  double place_tolerance_m = 3e-3;    ///< from the surface, and from the named position
  /// Where recordings have holds or several rates: whether they tell how the body relaxes, and
  /// whether rows in time follow from it where it is doubted, too.
  RelaxationUse relaxation = RelaxationUse::where_sure;
};

/// What recordings tell of a body's relaxation (method-recordings.md, section 25).
struct BodyRelaxation {
  RelaxationFit fit;  ///< of all recordings that were used; no branches where they show none
  struct PointSeries {
    std::string name;
    RelaxationFit fit;  ///< with as many branches as the body's
  };
  std::vector<PointSeries> points;  ///< those with a hold, where there are several
  struct Used {
    std::string file, point;
    double drift_share = 0;  ///< of the force lost in a hold, that its sensor's drift may be
  };
  std::vector<Used> recordings;  ///< in the order of fit.pictures, point by point
  bool has_holds = false;        ///< else several rates alone
  int creeping = 0;              ///< recordings whose force is held while the tool sinks
  /// Why rows in time would be worse than a mean of repeats: a phrase each.
  std::vector<std::string> doubts;
  bool is_applied = false;  ///< else proposed alone: samples do not have it
};

/// A recording on its way into the samples, or one that was refused.
struct PlacedRecording {
  std::size_t item = 0;                    ///< of the batch
  const Conditioned* recording = nullptr;  ///< of the results; null: refused before it had rows
  const Refused* refused = nullptr;        ///< of the results, then
  std::string name;                        ///< within its file
  std::string point;
  Vec3 position_m = Vec3::Zero();  ///< on the body
  Vec3 inward = Vec3::UnitZ();
  Mat3 to_body = Mat3::Identity();  ///< turns its deflections and forces into the body's frame
  /// NaN without a surface.
  double surface_distance_m = std::numeric_limits<double>::quiet_NaN();
  std::int32_t point_index = -1, experiment = -1;  ///< -1: refused
  /// From where the contact of the recording was found: where rows are in time, contacts of a point
  /// are aligned.
  std::optional<ContactShift> aligned = {};
  std::optional<Failure> failure;
};

/// "file.csv" or "file.csv#name".
std::string shown(const std::vector<BatchItem>& items, const PlacedRecording& placed);

/// A recording's contact, moved as presses of the body were aligned.
FoundContact contact_of(const PlacedRecording& placed);

struct Assembled {
  Samples samples;
  /// That of most recordings first: curves are of it, and rows of the others of the kind `other`,
  /// with their number here as Samples::probe_number. None where no radius is known.
  std::vector<UsedTip> tips;
  /// Every recording and every item that gave none, in order. Refers to the results.
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
                   const AssembleOptions& options);

/// Writes what became of every recording, whole or not at all: CSV with a row each
/// (file,line,point,status,grade,reason,remedy,...), and JSON with the same and the totals. The
/// same batch gives the same bytes, however it was interrupted.
void write_summary(const std::filesystem::path& csv, const std::filesystem::path& json,
                   const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const Assembled& assembled);

/// Writes what a picture of the relaxation needs: CSV with a row for each row of the recordings
/// that were used (file,point,time_s,depth_m,force_N,fitted_N).
void write_relaxation(const std::filesystem::path& csv, const BodyRelaxation& relaxation);

/// The totals and notes alone, with the refused recordings, as one JSON object for stdout.
std::string summary_json(const std::vector<BatchItem>& items,
                         const std::vector<ItemResult>& results, const Assembled& assembled);

/// Every recording with the signal that a picture is drawn from, in the order of the outcomes.
std::vector<RecordedSignal> signals_of(const std::vector<BatchItem>& items,
                                       const Assembled& assembled);

/// Line of a failure's place, "" when it names none.
std::string line_of(const Failure& failure);

}  // namespace palpate::recordings
