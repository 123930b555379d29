#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/shape/shape.hpp"
#include "libfit/validation/interval.hpp"

namespace palpate::validation {

/// Figure where no row counts: no number, null in JSON.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Points of a tool's shaft that torques are compared about (M58a), by their distances from its
/// point: the centre of a ball, where only friction turns it (0: the point), and the grip (0:
/// none).
struct Levers {
  double radius_m = 0, handle_m = 0;
};

/// A reference beside the answers to its rows, both of which must outlive it.
struct Comparison {
  const Samples& reference;
  const Replayed& answer;
  std::vector<Eigen::Index> rows;  ///< that are compared
  std::optional<Levers> levers;    ///< none: torques are not compared

  double force_N(Eigen::Index row) const { return reference.force.row(row).norm(); }
  double error_N(Eigen::Index row) const {
    return (answer.force_N.row(row) - reference.force.row(row)).norm();
  }
  /// Error of the force's size over the reference's, of at least floor_N.
  double magnitude_rel(Eigen::Index row, double floor_N) const;
  double direction_deg(Eigen::Index row) const;  ///< between both forces; NaN without one of them
  /// A person does not notice the error of its size and direction, in a force above 0.04 N
  /// (data/perception.toml).
  bool is_unnoticed(Eigen::Index row) const;
  /// Torque of the reference about a point of the shaft, and the answer's error [N m].
  Vec3 torque_Nm(Eigen::Index row, double lever_m) const {
    return about_Nm(reference.torque, reference.force, row, lever_m);
  }
  Vec3 torque_error_Nm(Eigen::Index row, double lever_m) const {
    return about_Nm(answer.torque_Nm, answer.force_N, row, lever_m) - torque_Nm(row, lever_m);
  }
  Vec3 about_Nm(const Points& torque_Nm, const Points& force_N, Eigen::Index row,
                double lever_m) const;
};

/// Good reference rows that were answered.
Comparison compare(const Samples& reference, const Replayed& answer,
                   std::optional<Levers> levers = std::nullopt);

/// Floors of the relative errors of a body (docs/method.md, M11a, docs/method-tools.md, M58a).
struct ErrorFloors {
  double force_N = 0, torque_Nm = 0, handle_Nm = 0;
};

/// The floors of a body of which these rows are all.
ErrorFloors floors_of(const Comparison& compared);

/// Relative error (p95) above which an asset is poor.
inline constexpr double kPoor = 0.1;

/// Share of the stated error above which a reference's own error is mentioned.
inline constexpr double kMentionedReference = 0.5;

/// Sizes of the errors of some rows, in N or N m, and the same over what the reference says there.
struct ErrorFigures {
  double typical = kNoNumber;  ///< median of what the reference says
  double median = kNoNumber, p95 = kNoNumber, max = kNoNumber;
  double median_rel = kNoNumber, p95_rel = kNoNumber, max_rel = kNoNumber;
};

/// An error's median and p95; between low and high p95 of all places lies 8 to 9 times of 10
/// (M11c), no numbers of fewer than two places and in sections.
struct Spread {
  double median = kNoNumber, p95 = kNoNumber, p95_low = kNoNumber, p95_high = kNoNumber;
};

/// Errors of one answer to some rows. Relative errors of forces, and of their size and direction,
/// are of the rows above the floor, those of torques of all rows, over the floor at least.
struct StatedError {
  std::string name;
  std::size_t rows = 0;
  ErrorFigures force = {};       ///< [N]
  Spread magnitude = {};         ///< error of the force's size over it
  Spread direction_deg = {};     ///< angle between the force and the reference's [degrees]
  double unnoticed = kNoNumber;  ///< share of rows above 0.04 N; no number: none is
  ErrorFigures torque = {};      ///< [N m], about the centre of a ball
  ErrorFigures handle = {};      ///< [N m], about the grip
  double tick_ns = kNoNumber;    ///< of all tools together; no number where it was not timed
};

/// Onset of slip on paths that slide first along one line: where the side force over the push has
/// come to 0.9 of its largest, in the reference and in the answer.
struct SlipOnset {
  std::size_t paths = 0;
  Spread place_m = {}, force_N = {};  ///< differences of travel [m] and of side force there [N]
};

/// Errors that belong side by side: of groups of the rows, or of several answers to them.
struct StatementSection {
  std::string name;   ///< in JSON, and of nothing else there
  std::string title;  ///< in words
  std::vector<StatedError> lines;
};

/// The error statement of an asset (docs/method.md, section 6). A figure is kNoNumber where no row
/// counts. Times of a tick are of the machine that validated.
struct Statement {
  StatedError all = {"all"};  ///< every held-out row of the asset's own probe
  /// Share of rows within max(0.04 N, 7 %); no number where no force reaches the threshold.
  double within_jnd = kNoNumber;
  double p95_rel_low = kNoNumber, p95_rel_high = kNoNumber;  ///< of all places, as in Spread
  SlipOnset slip_onset = {};
  double handle_m = 0;  ///< from the tool's point to its grip; 0: torques are not compared
  double reference_p95_rel = kNoNumber;  ///< the reference's own estimated error
  double within_reference = kNoNumber;   ///< share of those rows within it
  double floor_N = 0;                    ///< relative_floor_N of the reference
  std::size_t probes = 0;                ///< contact points
  std::size_t rows_above_floor = 0;
  std::size_t reference_failures = 0;  ///< rows whose reference did not work out
  std::size_t asset_bytes = 0;
  std::vector<StatementSection> sections = {};
  ShapeError shape = {};  ///< of the surface that is shown; no rows where none is
  /// The reference is recordings held out of the fit; else it is simulated.
  bool is_recorded = false;
  /// Share of a press's force that comes from where the body is held, in the middle of the window.
  double held_share = kNoNumber;
  std::optional<TruthInterval> interval = {};  ///< of the body itself, where it is known how well
  std::size_t beyond = 0;  ///< held-out points that the asset has no curves of its own for

  /// Lines of a section; none where there is no such section.
  const std::vector<StatedError>& lines_of(std::string_view section) const;
};

/// Figures of some rows of a body with these floors; quantiles are nearest-rank.
StatedError stated_error(std::string name, const Comparison& compared, const ErrorFloors& floors);

/// The same, group by group. group: of a row, an index of `names`; others are in no group. Groups
/// without a row are left out.
std::vector<StatedError> errors_by(const Comparison& compared, const ErrorFloors& floors,
                                   std::span<const std::string_view> names,
                                   const std::function<std::size_t(Eigen::Index row)>& group);

/// The statement of all rows of a body (M11a), without sections; the other fields are the caller's.
/// floors: of the body that the rows are some of; without them, of these rows.
Statement summarize(const Comparison& compared, const ErrorFloors& floors);
Statement summarize(const Comparison& compared);

/// The statement as an asset carries it: all but the advice, its words and what differs from one
/// machine or one writing to the next (tick_ns, asset_bytes), so that the same scene makes the same
/// bytes.
std::string to_asset_json(const Statement& statement);

/// The object others read (docs/formats/statement.md); one line.
std::string to_json(const Statement& statement);

/// The same with the hash of what it was made from, as statement.json holds it.
std::string to_json(const Statement& statement, const std::string& inputs);

/// Reads what to_json wrote. Throws Error at `where` when a name is missing or no number.
Statement parse_statement(const std::string& json, const std::string& where);

/// Grades an asset in a sentence or two.
std::string verdict(const Statement& statement);

/// Remedies for an asset that is off by more than kPoor, a sentence each; else nothing.
std::vector<std::string> advice(const Statement& statement);
/// The sentence on what is held; none where a twentieth of the force or less comes from there.
std::optional<std::string> advice_on_held_part(double held_share);

/// Sentences in lines of 80 characters, which a terminal holds, each with its end.
std::string wrapped(std::string_view text);

/// A table for people, 80 columns wide at most, then verdict and advice.
std::string in_words(const Statement& statement);

}  // namespace palpate::validation
