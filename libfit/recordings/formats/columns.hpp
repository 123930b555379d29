#pragma once

#include <functional>

#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/formats/text_file.hpp"

// From named columns to a recording: what CSV and HDF5 files have in common.

namespace palpate::importers {

enum class Meaning {
  time,
  force_time,
  depth,
  position,
  force,
  retract_depth,
  retract_force,
  contact,
  normal,
  desired,
  torque
};

/// One column that the settings ask for.
struct Role {
  Meaning meaning;
  int axis = 0;
  std::string name;  ///< in the file
  double sign = 1;   ///< -1 for a name given with a leading minus
};

/// Columns asked for, in a fixed order.
std::vector<Role> roles_of(const ColumnNames& names);

/// Index of each role's column among the names of a header, by the whole name or the name without
/// its unit in brackets. `fail` makes the error of a column that is missing or comes twice.
using FailColumn = std::function<Error(const std::string& what, const std::string& remedy)>;
std::vector<std::size_t> find_columns(const std::vector<Role>& roles,
                                      const std::vector<std::string>& header,
                                      const FailColumn& fail);

/// SI value of a role's column: its unit by the settings, else in the brackets of its header; 1 for
/// directions. Throws what `fail` makes when there is none, it is unknown, or the two differ.
double factor_of(const Role& role, const std::string& header_name, const UnitNames& units,
                 const FailColumn& fail);

/// A recording of columns in the file's units times `factors`. Precondition: lengths of `line`, but
/// for a force with a clock of its own.
RawRecording recording_of(const std::vector<Role>& roles, std::vector<std::vector<double>> columns,
                          const std::vector<double>& factors, std::vector<std::size_t> line,
                          const ReadSettings& settings);

}  // namespace palpate::importers
