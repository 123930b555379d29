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

/// The quantity that a name without unit is of, in any case of letters.
std::optional<Meaning> meaning_named(const std::string& name);

/// Columns that a header names by quantity and unit, such as "t_s", "x_mm" or "force (mN)": three
/// axes of a position or one depth, and a force. Empty where it names no such two.
struct NamedColumns {
  ColumnNames columns;
  std::string problem, remedy;  ///< what keeps the names from saying it; empty: nothing
};
NamedColumns columns_named(const std::vector<std::string>& header);

/// The settings with those columns where they name none, and a phrase of what was taken. Throws
/// what `fail` makes when the header has a problem or `force_on` is not said; as they are where the
/// header names none.
ReadSettings with_named_columns(const ReadSettings& settings,
                                const std::vector<std::string>& header, const FailColumn& fail,
                                std::string& taken);

/// SI value of a role's column: its unit by the settings, else in the brackets of its header or
/// behind its last underscore; 1 for directions. Throws what `fail` makes when there is none, it is
/// unknown, or the two differ.
double factor_of(const Role& role, const std::string& header_name, const UnitNames& units,
                 const FailColumn& fail);

/// A recording of columns in the file's units times `factors`. Precondition: lengths of `line`, but
/// for a force with a clock of its own.
RawRecording recording_of(const std::vector<Role>& roles, std::vector<std::vector<double>> columns,
                          const std::vector<double>& factors, std::vector<std::size_t> line,
                          const ReadSettings& settings);

/// A recording of whole arrays, as HDF5 and MATLAB files hold them: of the rows whose numbers are
/// all in range. Throws what `fail` makes for a role whose array has such a number and is not
/// dropped, is of another length than the first, or when no row is left.
using FailRole =
    std::function<Error(const Role&, const std::string& what, const std::string& remedy)>;
RawRecording recording_of_arrays(const std::vector<Role>& roles,
                                 std::vector<std::vector<double>> columns,
                                 const std::vector<double>& factors, const ReadSettings& settings,
                                 const FailRole& fail);

}  // namespace palpate::importers
