#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/shape/shape_error.hpp"

namespace palpate::validation {

/// One row of a comparison: what the reference says and what the engine answers [N], both on the
/// body.
struct ComparedRow {
  Vec3 reference_N = Vec3::Zero();
  Vec3 engine_N = Vec3::Zero();
  double reference_error_N = 0;  ///< the reference's own estimate; NaN where unknown
};

/// Of the p95 of a relative error: an asset above it is poor.
inline constexpr double kPoor = 0.1;

/// Of the error that is stated: a reference whose own error is above this share is told.
inline constexpr double kToldReference = 0.5;

/// What a figure is where no row counts: no number, null in JSON.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// A share of the error, or the error of something else on the same rows.
struct NamedError {
  std::string name;
  double median_N = kNoNumber, p95_N = kNoNumber;
  double median_rel = kNoNumber, p95_rel = kNoNumber;  ///< over rows above the body's floor_N
  double max_N = kNoNumber, max_rel = kNoNumber;       ///< stated of two tools alone
};

/// Torque errors of some rows (docs/method.md, M58a), relative ones with the floor of the body.
/// typical_Nm: median torque of the reference.
struct NamedTorque {
  std::string name;
  double typical_Nm = kNoNumber;
  double median_Nm = kNoNumber, p95_Nm = kNoNumber, max_Nm = kNoNumber;
  double median_rel = kNoNumber, p95_rel = kNoNumber, max_rel = kNoNumber;
};

/// The error statement of an asset (docs/method.md, section 6). A figure is kNoNumber where no row
/// counts. Times of a tick are of the machine that validated.
struct Statement {
  double median_N = kNoNumber, p95_N = kNoNumber, max_N = kNoNumber;
  double median_rel = kNoNumber, p95_rel = kNoNumber, max_rel = kNoNumber;  ///< above floor_N
  /// Share of rows within max(0.04 N, 7 %); no number where no force could be felt.
  double within_jnd = kNoNumber;
  double reference_p95_rel = kNoNumber;  ///< the reference's own estimated error
  double within_reference = kNoNumber;   ///< share of those rows within it
  double floor_N = 0;                    ///< relative_floor_N of the reference
  std::size_t probes = 0;                ///< contact points
  std::size_t rows = 0, rows_above_floor = 0;
  std::size_t reference_failures = 0;  ///< rows whose reference did not work out
  double tick_ns = kNoNumber;
  std::size_t asset_bytes = 0;
  std::vector<NamedError> by_path;       ///< by kind of path
  std::vector<NamedError> causes;        ///< what the error is made of; empty when not asked for
  std::vector<NamedError> baselines;     ///< of simpler responses on the same rows
  std::vector<NamedTorque> torque = {};  ///< of all rows, then by kind of path (torque.hpp)
  /// Held-out paths of two tools, both tools' rows: felt, and each tool by itself; nothing where
  /// there are none. two_tools_tick_ns: of both together.
  std::vector<NamedError> two_tools = {};
  double two_tools_tick_ns = kNoNumber;
  /// Held-out paths of the scene's [tool]: as balls that feel each other (`felt`), as balls by
  /// themselves and as its foremost ball alone; nothing where there is none.
  std::vector<NamedError> tool = {};
  std::vector<NamedTorque> tool_torque = {};
  double tool_tick_ns = kNoNumber;
  ShapeError shape = {};  ///< of the surface that is shown; no rows where none is
};

/// Error figures of the rows (M11a); the other fields are the caller's. Quantiles are nearest-rank.
/// floor_N: of the body that the rows are some of; without it, of these rows.
Statement summarize(const std::vector<ComparedRow>& rows, double floor_N);
Statement summarize(const std::vector<ComparedRow>& rows);

/// The figures of some rows of a body with this floor.
NamedError named_error(std::string name, const std::vector<ComparedRow>& rows, double floor_N);

/// What an asset carries of its statement: all but what differs from one machine or one writing to
/// the next (tick_ns, asset_bytes), so that the same scene gives the same bytes; and but for the
/// advice, the torque and what is stated of several tools.
std::string to_asset_json(const Statement& statement);

/// The object others read (docs/formats.md); one line.
std::string to_json(const Statement& statement);

/// The same with the hash of what it was made from, as statement.json holds it.
std::string to_json(const Statement& statement, const std::string& inputs);

/// Reads what to_json wrote. Throws Error at `where` when a name is missing or no number.
Statement parse_statement(const std::string& json, const std::string& where);

/// How good an asset is, in a sentence or two.
std::string verdict(const Statement& statement);

/// What to do about an asset that is off by more than kPoor, a sentence each; else nothing.
std::vector<std::string> advice(const Statement& statement);

/// A table for people, 80 columns wide at most, then verdict and advice.
std::string in_words(const Statement& statement);

}  // namespace palpate::validation
