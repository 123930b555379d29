#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// Carries points of the rig's frame into the body's: rotation * x + translation_m.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  Vec3 operator()(const Vec3& x) const { return rotation * x + translation_m; }
};

/// A motion with what it leaves: distances after it, root mean square and largest.
struct Registration {
  RigidMotion motion;
  double rms_m = 0, largest_m = 0;
  int iterations = 0;  ///< of ICP; 0 for landmarks alone
};

/// The motion that brings `from` nearest to `to` in the least squares sense, without mirroring.
/// Throws Error when there are fewer than 3 pairs or they lie on one line.
/// Source: Kabsch (1976), Umeyama (1991).
Registration register_landmarks(const Points& from, const Points& to);

/// Refines a motion so that `points` come to lie on the surface: iterative closest points with
/// distances along the surface's normals (Chen and Medioni 1992), up to 50 steps or until it moves
/// by less than 1e-9 of the surface. Points that lie farther than 3 robust deviations are left out
/// of a step. Throws Error with fewer than 6 points.
Registration register_to_surface(const Points& points, const Surface& surface,
                                 const RigidMotion& start);

/// Place of a point on a surface.
struct SurfacePlace {
  Vec3 position_m;
  Vec3 inward;  ///< unit, from the vertex normals
  double distance_m = 0;
};

/// Nearest surface points. Nothing where there is no triangle with an area.
std::vector<std::optional<SurfacePlace>> project(const Points& points, const Surface& surface);

/// How far a recording can be trusted; poor ones are imported, and listed.
enum class Grade : std::int8_t { good = 0, fair = 1, poor = 2 };

inline constexpr double kSeenInErrors = 3;      ///< deviations
inline constexpr double kMinForceInNoise = 20;  ///< of a fair recording
inline constexpr double kMinEffect = 0.05;      ///< of a force or its work: below the JND

/// Rows of one experiment: R of them, in the rig's frame or the body's.
struct ExperimentRows {
  Points deflection_m{0, 3};      ///< R x 3 since first touch
  Points force_N{0, 3};           ///< R x 3, of the tip ON the body, bias taken off
  Points torque_Nm{0, 3};         ///< R x 3, likewise; 0 rows where the recording has none
  Eigen::VectorXd time_s = {};    ///< R, since first touch; empty where rows have no time
  Eigen::VectorXd error_N;        ///< R, of a row's force, from the noise before contact
  std::vector<RowStatus> status;  ///< R; rejected where the force was saturated
};

/// One press, drag or path as samples, before it is known where on the body.
struct Conditioned : ExperimentRows {
  std::string name;               ///< within its file
  bool is_axial = false;          ///< deflection (depth, 0, 0), force (push, 0, 0)
  std::optional<Vec3> contact_m;  ///< where the tip touched, in the rig's frame
  std::optional<Vec3> inward;     ///< unit, in the rig's frame
  FoundContact contact;
  TimedPress history;     ///< of a press with a clock, all of it; else no rows
  double speed_m_s = 0;   ///< NaN without a clock
  double noise_N = 0;     ///< standard deviation of one reading without contact
  double hysteresis = 0;  ///< share of the work that unloading loses; NaN without all of it
  bool breaks = false;    ///< the tool broke in: what lies deeper was left out
  double young_Pa = 0;    ///< apparent, of the contact fit; NaN without radius or fit
  /// Young's modulus of an incompressible half-space that its tip presses as deep as the deepest
  /// row with its force; without a radius F / depth^2, the order of magnitude alone.
  double apparent_Pa = 0;
  Grade grade = Grade::good;
  std::vector<std::string> reasons;  ///< of the grade, a sentence each
  importers::RecordingSource source;
  SignalTrace trace;  ///< for a picture
};

/// Samples of a recording: one clock, filter, phases, contact point, bias, then R means over equal
/// steps of depth (press) or of the tip's path since contact (drag, path).
/// inward: unit, where the manifest or a surface says it. Throws Error (file:line, what, remedy) on
/// recordings from which no curve comes: no contact, reversed sign, saturated over most of the
/// depth, implausible stiffness, too few rows; what was seen of the signal then goes to `refused`.
Conditioned condition(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file,
                      SignalTrace* refused = nullptr);

/// Throws Error where settings are not the default that do nothing for a pass, of a scan or beside
/// one.
void check_pass_settings(const SignalSettings& settings, const std::string& file);

/// Passes of a scan, "1" to "N" in the recording's name: it is cut where the tool turns back, or
/// where it hardly does at equal times. Rows are readings, in time; the force keeps its bias.
/// inward: unit, else that of the mean force. Throws Error without a clock, three axes or 400 rows.
std::vector<Conditioned> condition_scan(const importers::RawRecording& raw,
                                        const SignalSettings& settings,
                                        const std::optional<Vec3>& inward, const std::string& file);

/// "file:line" of a row.
std::string place(const std::string& file, const Signal& signal, Eigen::Index row);

// Steps of `condition`, in their order.

/// Finds approach, loading and break of the press that the settings ask for. Notes
/// in `out` that there are others as deep, and how they differ. Throws Error (file:line, what,
/// remedy) where the tip never goes in, or not as often as `cycle` asks for.
void find_ranges(const SignalSettings& settings, const std::string& file, Signal& signal,
                 Conditioned& out);

/// Finds the contact point as the settings ask for it, given or estimated from the loading and
/// `cycles`, takes the mean (or line) of the free push off all rows and axes of `signal`, and fills
/// in contact, noise and speed of `out`. Throws Error (file:line, what, remedy) where the loading
/// holds no contact or has the other sign.
ContactEstimate find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::string& file, const std::vector<RowRange>& cycles,
                             Signal& signal, Conditioned& out);

/// Fills the rows of `out` from the signal's used ranges: means over equal steps of depth for a
/// press, of the tip's path since contact for a drag or path, or every reading of a pass. Errors
/// are the noise over the square root of the readings that count (neighbours with correlation r
/// count (1 - r) / (1 + r)).
void take_rows(const Signal& signal, const SignalSettings& settings, Conditioned& out);

/// The presses of a recording with three axes, a recording for each place in the order pressed, "1"
/// to "9" in the recording's name: where the tool lifts off, goes sideways by more than either
/// press is deep, and presses again. The recording as it is where there is one place, and where
/// `condition` is going to refuse it. inward: unit, where the manifest says it.
std::vector<importers::RawRecording> split_places(const importers::RawRecording& raw,
                                                  const SignalSettings& settings,
                                                  const std::optional<Vec3>& inward);

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

/// A recording without result.
struct Refused {
  std::string name;  ///< within its file; empty of a whole file
  Error failure;
  SignalTrace trace;  ///< as far as it is known
};

/// The recordings of an item, and those that were refused.
struct ItemResult {
  std::string hash;  ///< ContentHash of the file's bytes; empty when they could not be read
  std::vector<Conditioned> recordings;
  std::vector<Refused> refused;
  bool is_done = false;  ///< else the batch was stopped before
};

/// Uses of the relaxation that recordings show.
enum class RelaxationUse { none, where_sure, always };

/// Options of reading a batch into samples on a body.
struct BatchOptions {
  int jobs = 0;                            ///< threads, 0: all. Results do not depend on it
  const Surface* surface = nullptr;        ///< of the body, onto which positions are projected
  std::optional<RigidMotion> motion = {};  ///< rig to body, where it is known
  bool fits_to_surface = false;            ///< refine it by the contact points
  double place_tolerance_m = 3e-3;         ///< from the surface, and from the named position
  /// Recordings with holds or several rates show how the body relaxes: rows in time follow from it
  /// never, where it is sure, or where it is doubted, too.
  RelaxationUse relaxation = RelaxationUse::where_sure;
};

/// Reads and conditions every item, in parallel; a bad one becomes a failure and stops nothing.
/// Recordings whose contact the surface says better than they do are conditioned a second time,
/// with it. Returns a result per item, in their order. Stops early, with items not done, when
/// Progress says so.
std::vector<ItemResult> run_batch(const std::vector<BatchItem>& items, const BatchOptions& options,
                                  const Progress& progress);

/// A unit that would bring an implausible modulus to where it belongs.
struct LikelyUnit {
  std::string key;   ///< "units.force", "units.position"
  std::string unit;  ///< what the manifest should probably say
};

/// The unit of force or length that brings `found_Pa` nearest to `expected_Pa`, of those that bring
/// it within a factor of 30; nothing when none does. factor steps are those of SI prefixes. given:
/// the manifest's units, "N" and "mm" where empty.
std::optional<LikelyUnit> likely_unit(double found_Pa, double expected_Pa,
                                      const std::string& force_unit, const std::string& length_unit,
                                      bool has_radius);

/// Why recordings are refused whose apparent modulus no body has (outside their `plausible`), or is
/// a prefix away from that of the others that were made like them. By item and recording of
/// `results`; nothing where a recording is plausible.
std::vector<std::vector<std::optional<Error>>> question_stiffness(
    const std::vector<BatchItem>& items, const std::vector<ItemResult>& results);

/// A sentence on every item whose file holds the bytes of an earlier one and is read as that is:
/// repeats that are none make errors too small, and points that were never pressed.
std::vector<std::string> copy_notes(const std::vector<BatchItem>& items,
                                    const std::vector<ItemResult>& results);

}  // namespace palpate::recordings
