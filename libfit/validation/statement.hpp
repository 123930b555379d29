#pragma once

#include <cstddef>
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

/// A share of the error, or the error of something else on the same rows.
struct NamedError {
  std::string name;
  double median_N = 0, p95_N = 0;
  double median_rel = 0, p95_rel = 0;  ///< over rows above kForceFloor_N
  double max_N = 0, max_rel = 0;       ///< stated of two tools alone
};

/// Torque errors of some rows (docs/method.md, M58a): relative ones with a floor of
/// kTorqueFloor_Nm. typical_Nm: median torque of the reference.
struct NamedTorque {
  std::string name;
  double typical_Nm = 0;
  double median_Nm = 0, p95_Nm = 0, max_Nm = 0;
  double median_rel = 0, p95_rel = 0, max_rel = 0;
};

/// The error statement of an asset (docs/method.md, section 6).
struct Statement {
  double median_N = 0, p95_N = 0, max_N = 0;
  double median_rel = 0, p95_rel = 0, max_rel = 0;  ///< over rows above kForceFloor_N
  double within_jnd = 0;                            ///< share of rows within max(0.04 N, 7 %)
  double reference_p95_rel = 0;                     ///< the reference's own estimated error
  double within_reference = 0;                      ///< share of those rows within it
  std::size_t probes = 0;                           ///< contact points
  std::size_t rows = 0, rows_above_floor = 0;
  std::size_t reference_failures = 0;  ///< rows whose reference did not work out
  double tick_ns = 0;
  std::size_t asset_bytes = 0;
  std::vector<NamedError> by_path;       ///< by kind of path
  std::vector<NamedError> causes;        ///< what the error is made of; empty when not asked for
  std::vector<NamedError> baselines;     ///< of simpler responses on the same rows
  std::vector<NamedTorque> torque = {};  ///< of all rows, then by kind of path (torque.hpp)
  /// The same rows by the assets of a tool that turns; nothing where there are none.
  std::vector<NamedError> turning = {};
  std::vector<NamedTorque> turning_torque = {};
  double turning_tick_ns = 0;
  /// Held-out paths of two tools, both tools' rows: felt, and each tool by itself; nothing where
  /// there are none. two_tools_tick_ns: of both together.
  std::vector<NamedError> two_tools = {};
  double two_tools_tick_ns = 0;
  /// Held-out paths of the scene's [tool]: as balls that feel each other (`felt`), as balls by
  /// themselves and as its foremost ball alone; nothing where there is none.
  std::vector<NamedError> tool = {};
  std::vector<NamedTorque> tool_torque = {};
  double tool_tick_ns = 0;
  ShapeError shape = {};  ///< of the surface that is shown; no rows where none is
};

/// Error figures of the rows (M11a); the other fields are the caller's. Quantiles are nearest-rank.
Statement summarize(const std::vector<ComparedRow>& rows);

/// The four figures of some rows.
NamedError named_error(std::string name, const std::vector<ComparedRow>& rows);

/// What an asset carries of its statement: all but what differs from one machine or one writing to
/// the next (tick_ns, asset_bytes), so that the same scene gives the same bytes; and but for the
/// torque of a tool that does not turn.
std::string to_asset_json(const Statement& statement);

/// The object others read (docs/formats.md); one line.
std::string to_json(const Statement& statement);

/// The same with the hash of what it was made from, as statement.json holds it.
std::string to_json(const Statement& statement, const std::string& inputs);

/// Reads what to_json wrote. Throws Error at `where` when a name is missing or no number.
Statement parse_statement(const std::string& json, const std::string& where);

/// A table for people, 80 columns wide at most.
std::string in_words(const Statement& statement);

}  // namespace palpate::validation
