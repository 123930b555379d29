#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/core/relaxation.hpp"
#include "libfit/core/tilt.hpp"

namespace palpate {

/// What was done to the body in an experiment.
enum class ExperimentKind : std::int8_t {
  press = 0,
  drag = 1,
  path = 2,   ///< any way of one tool
  cycle = 3,  ///< a press in and out of a body that softens
  pair = 4,   ///< two tools side by side
  tool = 5,   ///< the scene's [tool] along a path
  other = 6,  ///< a path of another tool than the samples' own
};
inline constexpr std::array<std::string_view, 7> kExperimentKindNames{
    "press", "drag", "path", "cycle", "pair", "tool", "other"};

/// What is done at every test point (docs/method.md, section 5): a press to depth_m in equal steps,
/// and at each drag depth a drag of drag_distance_m along each direction, at constant depth, with
/// rows that lie closer at the beginning, where the interface sticks and slips in part.
struct Experiments {
  double depth_m = 0.010;
  int press_steps = 10;
  std::vector<double> drag_depths_m;
  double drag_distance_m = 0.008;
  int drag_directions = 2;
  int drag_steps = 8;
};

/// Whether a row can be believed. Recorded, never dropped: only `good` rows are fitted.
enum class RowStatus : std::int8_t {
  good = 0,
  not_converged = 1,  ///< the equations were not solved to tolerance
  inverted = 2,       ///< an element turned inside out and the step could not be cut further
  rejected = 3,       ///< solved, but failed a sanity check (force sign, slope, penetration, area)
  no_contact = 4,     ///< the probe touches nothing although the deflection is into the body
  not_reached = 5,    ///< an earlier step of the experiment failed
  wedged = 6,         ///< a press whose force stands more than 45 degrees off it; force is kept
};

/// Whether a row's force is the solution of its equations, to be believed or not.
inline bool is_solved(RowStatus status) {
  return status == RowStatus::good || status == RowStatus::wedged;
}

/// What a row's checks found (docs/method-simulator.md, section 10, Acceptance). `falls` is of good
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

/// What is known of the recordings behind measured samples: group `recordings` of samples.h5. R
/// recordings, in the order of the manifest; several of one experiment were pooled. All empty for
/// simulated samples.
struct MeasuredRecordings {
  std::vector<std::int32_t> experiment;  ///< R, of rows/experiment
  std::vector<std::string> file;  ///< R, as the manifest names it, with `#name` within a file
  std::vector<std::string> hash;  ///< R, ContentHash of the file's bytes
  Eigen::VectorXd
      contact_m;  ///< R, travel at which the tip touched first, in the recording's own zero
  Eigen::VectorXd contact_deviation_m;  ///< R, its standard deviation: a fit with free contact
                                        ///< point starts here
  std::vector<std::string> estimator;   ///< R, that found it
  Eigen::VectorXd speed_m_s;            ///< R, loading rate; NaN without a clock
  Eigen::VectorXd noise_N;              ///< R, standard deviation of one reading without contact
  Eigen::VectorXd hysteresis;      ///< R, share of the work not given back; NaN without a way back
  Eigen::VectorXd young_Pa;        ///< R, apparent, of the contact fit; NaN where it has none
  std::vector<std::int8_t> grade;  ///< R: 0 good, 1 fair, 2 poor
  std::vector<std::string> reasons;  ///< R, of the grade; empty when good

  std::size_t size() const { return experiment.size(); }
};

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

/// Where experiments are made, P places of a body.
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

/// What a tool did and met, N rows in experiment order. deflection N x 3 [m], force N x 3 [N] of
/// the tool ON the body, torque N x 3 [N m] about the probe's reference point, force_error N [N].
/// Where several tools are on the body at once each has a row of its own, one after the other, at
/// its own place and with its number in `tool`.
struct SampleRows {
  std::vector<std::int32_t> point;       ///< N, index of the place
  std::vector<std::int32_t> experiment;  ///< N, unique per press, drag or path
  std::vector<ExperimentKind> kind;      ///< N
  std::vector<std::int32_t> step;        ///< N
  std::vector<std::int32_t> tool;        ///< N, from 0 on; or none: each experiment has one tool
  /// N: 0 of the samples' own probe, i of other_probes[i - 1]; or none: all are of their own.
  std::vector<std::int32_t> probe_number;
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
};

/// What made the rows, and of which body.
struct SampleOrigin {
  std::optional<ProbeSpec> probe;       ///< that made them; none where unknown
  std::vector<ProbeSpec> other_probes;  ///< that rows of the kind `other` are of
  double poisson = std::numeric_limits<double>::quiet_NaN();  ///< of the body; NaN where unknown
  Relaxation relaxation;  ///< of the body, where it is known; rows without time do not feel it
  MeasuredRecordings recordings;  ///< where measured rows came from; empty when simulated
};

/// Experiments at places of a body, simulated or measured: samples.h5 in memory (docs/formats.md).
struct Samples : SamplePlaces, SampleRows, SampleOrigin {};

/// Each column of places, each of rows, for whatever copies, reads or writes all of them: f(column
/// of a, column of b, what a place or row has where the column is missing; no such argument: it is
/// never missing). The surface's motion, which is as large as the rest a thousand times, stands by
/// itself.
template <class A, class B, class F>
void each_point_column(A& a, B& b, const F& f) {
  f(a.point_position, b.point_position);
  f(a.point_normal, b.point_normal);
  f(a.point_name, b.point_name);
  f(a.point_normal_gradient, b.point_normal_gradient, 0.0);
  f(a.point_sway, b.point_sway, 0.0);
  f(a.point_scale, b.point_scale, 0.0);
}
template <class A, class B, class F>
void each_row_column(A& a, B& b, const F& f) {
  f(a.point, b.point);
  f(a.experiment, b.experiment);
  f(a.kind, b.kind);
  f(a.step, b.step);
  f(a.tool, b.tool, std::int32_t{0});
  f(a.probe_number, b.probe_number, std::int32_t{0});
  f(a.deflection, b.deflection);
  f(a.force, b.force);
  f(a.torque, b.torque);
  f(a.force_error, b.force_error);
  f(a.status, b.status);
  f(a.step_check, b.step_check, StepCheck::none);
  f(a.time_s, b.time_s, std::numeric_limits<double>::quiet_NaN());
  f(a.lean, b.lean, 0.0);
}

/// A second tool of the same shape on the same body: where it touches first, and how it moves from
/// there while the first one follows its path.
struct SecondTool {
  Vec3 position, normal;    ///< on the surface [m], inward unit
  Points deflections;       ///< N x 3 [m]
  std::int32_t place = -1;  ///< its number, in a list of experiments
};

/// Where a tool goes: successive deflections (N x 3 [m]) from first touch at a test point. time_s:
/// when it is there, as of Samples; empty: in slow motion. lean: all along.
struct ToolPath {
  int point = 0;
  Points deflections;
  Eigen::VectorXd time_s = {};  ///< N [s] since first touch; empty: slow motion
  Lean lean = Lean::Zero();
  std::optional<SecondTool> second = std::nullopt;
};

/// What is simulated at a test point.
struct Effort {
  bool is_dragged = false;  ///< or pressed alone
  double scale = 0;         ///< of a press on one mesh (Samples::point_scale); 0: on two
};

}  // namespace palpate
