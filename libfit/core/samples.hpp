#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"

namespace palpate {

/// Kind of an experiment.
enum class ExperimentKind : std::int8_t {
  press = 0,
  drag = 1,
  path = 2,   ///< any way of one tool
  cycle = 3,  ///< a press in and out of a body that softens
  pair = 4,   ///< two tools side by side
  tool = 5,   ///< the scene's [tool] along a path
  other = 6,  ///< a path of another tool than the samples' own
  scan = 7,   ///< a pass of a tool that presses and slides in one go, in its recording's time
};
inline constexpr std::array<std::string_view, 8> kExperimentKindNames{
    "press", "drag", "path", "cycle", "pair", "tool", "other", "scan"};

/// The shape of a drawn path. Draws take the upright ones in turn.
enum class PathKind : std::int8_t {
  straight = 0,
  oblique = 1,
  sliding = 2,
  back_and_forth = 3,
  wandering = 4,
  tilting = 5,  ///< with a tool that leans; only where it is asked for
  none = 6,     ///< a press, a drag or a path that nobody drew
};
inline constexpr std::size_t kUprightKinds = 5;
inline constexpr std::array<std::string_view, 7> kPathKindNames{
    "straight", "oblique", "sliding", "back_and_forth", "wandering", "tilting", "none"};

/// Experiments at every test point (docs/method.md, section 5): a press to depth_m in equal steps,
/// and at each drag depth a drag of drag_distance_m along each direction, at constant depth: rows
/// lie closer where the interface begins to slip, and the last one of several is back at the start.
struct Experiments {
  double depth_m = 0.010;
  int press_steps = 10;
  std::vector<double> drag_depths_m;
  double drag_distance_m = 0.008;
  int drag_directions = 2;
  int drag_steps = 8;
};

/// Outcome of a row. Every row is recorded, but only `good` rows are fitted.
enum class RowStatus : std::int8_t {
  good = 0,
  not_converged = 1,  ///< the equations were not solved to tolerance
  inverted = 2,       ///< an element turned inside out and the step could not be cut further
  rejected = 3,       ///< solved, but failed a sanity check (force sign, slope, penetration, area)
  no_contact = 4,     ///< the probe touches nothing although the deflection is into the body
  not_reached = 5,    ///< an earlier step of the experiment failed
  wedged = 6,         ///< a press whose force stands more than 45 degrees off it; force is kept
};

/// True if a row's force is the solution of its equations, to be believed or not.
inline bool is_solved(RowStatus status) {
  return status == RowStatus::good || status == RowStatus::wedged;
}

/// Finding of a row's checks (docs/method-simulator.md, section 10, Acceptance). `falls` is of good
/// rows, the others say why a row is `rejected` or `inverted`.
enum class StepCheck : std::int8_t {
  none = 0,
  inverted = 1,       ///< det F <= 0 somewhere
  overlaps = 2,       ///< the body reaches too far into the probe
  no_area = 3,        ///< a press that touches nothing
  pulls = 4,          ///< the force does not point into the body
  does_not_rise = 5,  ///< a deeper press with no larger force, and no stable branch that falls
  falls = 6,          ///< on a stable branch past a limit point: deeper presses have less force
};

inline constexpr std::array<std::string_view, 7> kStepCheckNames{
    "none", "inverted", "overlaps", "no_area", "pulls", "does_not_rise", "falls"};

inline constexpr std::array<std::string_view, 7> kRowStatusNames{
    "good", "not_converged", "inverted", "rejected", "no_contact", "not_reached", "wedged"};

constexpr std::string_view name_of(ExperimentKind kind) {
  return kExperimentKindNames[static_cast<int>(kind)];
}
constexpr std::string_view name_of(PathKind kind) { return kPathKindNames[static_cast<int>(kind)]; }
constexpr std::string_view name_of(RowStatus status) {
  return kRowStatusNames[static_cast<int>(status)];
}
constexpr std::string_view name_of(StepCheck check) {
  return kStepCheckNames[static_cast<int>(check)];
}

/// Facts of R recordings beside their readings, in the order of the manifest.
struct RecordingColumns {
  std::vector<std::int32_t> experiment;  ///< R, of rows/experiment; -1 of refused ones
  std::vector<std::string> file;  ///< R, as the manifest names it, with `#name` within a file
  std::vector<double> contact_m;  ///< R, travel at first touch, in the recording's own zero
  /// R, its standard deviation: a fit with free contact point starts here.
  std::vector<double> contact_deviation_m;
  std::vector<std::string> estimator;  ///< R, that found it; empty where there is none
  std::vector<double> noise_N;         ///< R, standard deviation of one reading without contact
  std::vector<std::int8_t> grade;      ///< R, of kRecordingGradeNames
  std::vector<std::string> reasons;    ///< R, of the grade; why it was refused, and the remedy

  std::size_t size() const { return experiment.size(); }
};

/// The recordings behind measured samples: group `recordings` of samples.h5. Several of one
/// experiment were pooled. All empty for simulated samples.
struct MeasuredRecordings : RecordingColumns {
  std::vector<std::string> hash;   ///< R, ContentHash of the file's bytes
  std::vector<double> speed_m_s;   ///< R, loading rate; NaN without a clock
  std::vector<double> hysteresis;  ///< R, share of the work not given back; NaN without a way back
  std::vector<double> young_Pa;    ///< R, apparent, of the contact fit; NaN where it has none
};

/// Standard deviation of each experiment's contact point [m], of the recordings that state one:
/// that of the mean of them.
std::map<std::int32_t, double> contact_deviations_m(const MeasuredRecordings& recordings);

/// Displacements of a surface's vertices, a row per state.
using SurfaceMotion = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Symmetric 3 x 3 matrices, a row each: xx, yy, zz, xy, xz, yz.
using SymmetricRows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;
inline Mat3 symmetric_of(const Eigen::Matrix<double, 1, 6>& n) {
  return Mat3{{n[0], n[3], n[4]}, {n[3], n[1], n[5]}, {n[4], n[5], n[2]}};
}
inline Eigen::Matrix<double, 1, 6> numbers_of(const Mat3& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
}

/// P places of a body at which experiments are made.
struct SamplePlaces {
  Points point_position;                ///< P x 3 [m]
  Points point_normal;                  ///< P x 3, inward unit
  std::vector<std::string> point_name;  ///< P
  /// P x 9 or 0 x 9 [1/m]: row-major du/dc of the inward unit normal field u along the surface at
  /// each point (symmetric; its null space contains the normal). On a sphere of radius R, -1/R on
  /// tangents. Lets the fit replay drags on the curved surface; absent means flat.
  Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> point_normal_gradient;
  /// P x 6 or 0 x 6 [m/N], of simulated points: how the body moves as a whole under a force there
  /// (docs/method-body.md, section 21), xx, yy, zz, xy, xz, yz; zero where that is not known.
  SymmetricRows point_sway;
  /// P or 0: of a press on one mesh, s_0 of the deepest step, by which and by a line over the force
  /// its forces were multiplied (docs/method.md, M13e); 0 of points whose rows come from two
  /// meshes.
  Eigen::VectorXd point_scale;

  Eigen::Index points() const { return point_position.rows(); }
};

/// Format of a column in a file. names: of its codes. is_optional: without rows it is not
/// written.
struct ColumnFormat {
  std::string_view unit = "1";
  bool may_be_nan = false;
  std::span<const std::string_view> names = {};
  bool is_optional = false;
};

/// Motion of a tool and the body's answer, N rows in experiment order. deflection N x 3 [m], force
/// N x 3 [N] of the tool ON the body, torque N x 3 [N m] about the probe's reference point,
/// force_error N [N]. Where several tools are on the body at once each has a row of its own, one
/// after the other, at its own place and with its number in `tool`.
struct SampleRows {
  std::vector<std::int32_t> point;       ///< N, index of the place
  std::vector<std::int32_t> experiment;  ///< N, unique per press, drag or path
  std::vector<ExperimentKind> kind;      ///< N
  std::vector<std::int32_t> step;        ///< N
  std::vector<std::int32_t> tool;        ///< N, from 0 on; or none: each experiment has one tool
  /// N: 0 of the samples' own probe, i of other_probes[i - 1]; or none: all are of their own.
  std::vector<std::int32_t> probe_number;
  std::vector<PathKind> path;         ///< N; or none: no path was drawn
  Points deflection;                  ///< N x 3 [m]
  Points force;                       ///< N x 3 [N]
  Points torque;                      ///< N x 3 [N m]
  Eigen::VectorXd force_error;        ///< N [N], estimated; NaN where unknown
  std::vector<RowStatus> status;      ///< N
  std::vector<StepCheck> step_check;  ///< N, or none at all where nothing checked
  /// N [s] since the first touch of the experiment, rising within it, between rows the tool moves
  /// at constant speed; NaN in slow motion. Empty: all rows are of slow motion, or have no clock.
  Eigen::VectorXd time_s;
  /// N x 2, how the tool leans (docs/method-tools.md, section 27); nothing where it is upright in
  /// all.
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> lean;
  /// N x 3V [m], of simulated rows: x, y, z of each vertex of the fine surface in turn, how far it
  /// has moved; 0 of rows that are not good. No rows where it was not kept. A file of its own.
  SurfaceMotion surface;

  Eigen::Index rows() const { return deflection.rows(); }
  int tool_of(Eigen::Index row) const { return tool.empty() ? 0 : tool[row]; }
  int probe_of(Eigen::Index row) const { return probe_number.empty() ? 0 : probe_number[row]; }
  double time_of(Eigen::Index row) const { return time_s.size() > 0 ? time_s[row] : kNan; }
  Lean lean_at(Eigen::Index row) const {
    return lean.rows() > 0 ? Lean(lean.row(row)) : Lean(Lean::Zero());
  }
  PathKind path_of(Eigen::Index row) const { return path.empty() ? PathKind::none : path[row]; }
};

/// Probes, body and recordings that rows come from.
struct SampleOrigin {
  std::optional<ProbeSpec> probe;       ///< that made them; none where unknown
  std::vector<ProbeSpec> other_probes;  ///< that rows of the kind `other` are of
  double poisson = kNan;                ///< of the body; NaN where unknown
  Relaxation relaxation;  ///< of the body, where it is known; rows without time do not feel it
  MeasuredRecordings recordings;  ///< where measured rows came from; empty when simulated
};

/// Experiments at places of a body, simulated or measured: samples.h5 in memory (docs/formats.md).
struct Samples : SamplePlaces, SampleRows, SampleOrigin {};

/// The columns of places and of rows, for whatever copies, reads or writes all of them:
/// f(name in a file, member, format, entry of a place or row where the column is missing; no such
/// argument: it is never missing). The surface's motion, which is as large as the rest a thousand
/// times, stands by itself.
template <class F>
void each_point_column(const F& f) {
  using S = SamplePlaces;
  f("points/position", &S::point_position, ColumnFormat{"m"});
  f("points/normal", &S::point_normal, ColumnFormat{});
  f("points/name", &S::point_name, ColumnFormat{});
  f("points/normal_gradient", &S::point_normal_gradient,
    ColumnFormat{.unit = "1/m", .is_optional = true}, 0.0);
  f("points/sway", &S::point_sway, ColumnFormat{.unit = "m/N", .is_optional = true}, 0.0);
  f("points/scale", &S::point_scale, ColumnFormat{.is_optional = true}, 0.0);
}
template <class F>
void each_row_column(const F& f) {
  using S = SampleRows;
  const ColumnFormat optional{.is_optional = true};
  f("rows/point", &S::point, ColumnFormat{});
  f("rows/experiment", &S::experiment, ColumnFormat{});
  f("rows/kind", &S::kind, ColumnFormat{.names = kExperimentKindNames});
  f("rows/step", &S::step, ColumnFormat{});
  f("rows/tool", &S::tool, optional, std::int32_t{0});
  f("rows/probe", &S::probe_number, optional, std::int32_t{0});
  f("rows/path", &S::path, ColumnFormat{.names = kPathKindNames, .is_optional = true},
    PathKind::none);
  f("rows/deflection", &S::deflection, ColumnFormat{"m"});
  f("rows/force", &S::force, ColumnFormat{"N", true});
  f("rows/torque", &S::torque, ColumnFormat{"N m", true});
  f("rows/force_error", &S::force_error, ColumnFormat{"N", true});
  f("rows/status", &S::status, ColumnFormat{.names = kRowStatusNames});
  f("rows/step_check", &S::step_check, ColumnFormat{.names = kStepCheckNames, .is_optional = true},
    StepCheck::none);
  f("rows/time", &S::time_s, ColumnFormat{"s", true, {}, true}, kNan);
  f("rows/lean", &S::lean, optional, 0.0);
}

/// Appends places, or rows, of `from` by their numbers. Columns that either lacks are filled; where
/// rows of either do not say how the surface moved, none of the result do.
void append_points(SamplePlaces& to, const SamplePlaces& from,
                   const std::vector<Eigen::Index>& which);
void append_rows(SampleRows& to, const SampleRows& from, const std::vector<Eigen::Index>& which);
/// Rows of all parts, one after the other.
SampleRows joined_rows(const std::vector<const SampleRows*>& parts);

/// Places and rows of both, those of `first` in front, experiments numbered anew; places of both
/// come twice. Rows of a second without places are at those of the first.
Samples joined(const Samples& first, const Samples& second);

/// Rows from `first` on, at the same places.
Samples row_range(const Samples& samples, Eigen::Index first, Eigen::Index count);

/// Removes optional columns of rows in which every entry is that of a missing one.
void remove_void_columns(SampleRows& rows);

/// The rows that are wanted, by number, at their places, which keep their order; columns that are
/// then void are left out.
Samples rows_where(const Samples& samples, const std::function<bool(Eigen::Index row)>& is_wanted);
Samples of_kinds(const Samples& samples, std::initializer_list<ExperimentKind> kinds);
/// The rows at the places that are marked, or at the others.
Samples rows_at(const Samples& samples, const std::vector<char>& is_marked, bool wanted);

/// Puts deflection and force of presses, holds and cycles onto the normal of their place: a press
/// tells force over depth, and what an encoder's noise, a rig that leans or a frame that drifted
/// add sideways is neither motion along the surface nor friction. A press that goes straight keeps
/// every bit, its side force too (simulated ones do). A press stays as it is also where it was
/// moved sideways on purpose: by more than a third of its depth, and with a force along that motion
/// beyond what the rows scatter by. Returns the experiments that stay so, ascending.
std::vector<std::int32_t> straighten_presses(Samples& samples);

/// True if straighten_presses() would change a row.
bool has_crooked_press(const Samples& samples);

/// A second tool of the same shape on the same body: where it touches first, and how it moves from
/// there while the first one follows its path.
struct SecondTool {
  Vec3 position, normal;    ///< on the surface [m], inward unit
  Points deflections;       ///< N x 3 [m]
  std::int32_t place = -1;  ///< its number, in a list of experiments
};

/// Path of a tool: successive deflections (N x 3 [m]) from first touch at a test point. time_s:
/// when it is there, as of Samples; empty: in slow motion. lean: all along.
struct ToolPath {
  int point = 0;
  Points deflections;
  Eigen::VectorXd time_s = {};  ///< N [s] since first touch; empty: slow motion
  Lean lean = Lean::Zero();
  std::optional<SecondTool> second = std::nullopt;
  PathKind kind = PathKind::none;

  double time_of(Eigen::Index row) const { return time_s.size() > 0 ? time_s[row] : kNan; }
};

/// Work at a test point.
struct Effort {
  bool is_dragged = false;  ///< or pressed alone
  double scale = 0;         ///< of a press on one mesh (Samples::point_scale); 0: on two
};

inline constexpr std::array<std::string_view, 5> kPhaseNames{"approach", "hold", "retract", "slide",
                                                             "unknown"};
inline constexpr std::array<std::string_view, 4> kRecordingGradeNames{"good", "fair", "poor",
                                                                      "refused"};
inline constexpr std::int8_t kRefusedGrade = 3;

/// Readings of one recording that a picture of it is drawn from, in the order recorded; without any
/// where the file gave no signal. N readings.
struct SignalTrace {
  std::vector<float> time_s;         ///< N since the first reading; NaN without a clock
  std::vector<float> travel_m;       ///< N along the inward direction, in the recording's own zero
  std::vector<float> push_N;         ///< N of the tip ON the body along it, as recorded
  std::vector<std::int8_t> phase;    ///< N, of kPhaseNames
  std::vector<char> is_used;         ///< N: 1 where samples come from
  double bias_N = 0, drift_N_m = 0;  ///< what was taken off the push: bias_N + drift_N_m travel

  std::size_t readings() const { return push_N.size(); }
};

/// Recordings of an import as they came, imported or refused: samples.signals.h5
/// (docs/formats.md), with the N readings of all of them, one recording's after another's. Numbers
/// are NaN where there are none.
struct RecordedSignals : RecordingColumns {
  std::vector<std::string> point;                ///< R, of the samples
  std::vector<double> bias_N, drift_N_m;         ///< R, as SignalTrace has them
  std::vector<std::int32_t> readings;            ///< R
  std::vector<double> time_s, travel_m, push_N;  ///< N
  std::vector<std::int8_t> phase;                ///< N
  std::vector<char> is_used;                     ///< N
};

}  // namespace palpate
