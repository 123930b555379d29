#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::importers {

/// Which columns of a file mean what, by the names in its header ("#3" is the third column of a
/// file without header; a leading minus turns the sign). Empty where the file has none.
struct ColumnNames {
  std::string time, depth;
  std::string force_time;                    ///< clock of the force columns, when it is another
  std::vector<std::string> position, force;  ///< three axes; one force column: along the depth
  std::vector<std::string> contact, normal;  ///< per row: where the press began, inward or outward
  std::vector<std::string> torque;           ///< three axes, about the tip
  bool has_signal() const { return !depth.empty() || !position.empty() || !force.empty(); }
  bool operator==(const ColumnNames&) const = default;
};

/// Units by name; empty where the header has to say it in brackets.
struct UnitNames {
  std::string time, position, force;
  std::string torque = {};
  bool operator==(const UnitNames&) const = default;
};

/// A key that a manifest says, and where: "manifest.toml:5:14".
struct SaidKey {
  std::string name, where;
  bool operator==(const SaidKey& other) const { return name == other.name; }
};

/// Options of reading one file. The defaults let a file speak for itself.
struct ReadSettings {
  std::string format = "auto";  ///< a name of kImporters
  ColumnNames columns;
  UnitNames units;
  std::optional<bool> is_force_on_tool;  ///< else on the body; tables ask for it
  bool is_normal_outward = false;        ///< of columns.normal
  char separator = 0;                    ///< 0: tab, semicolon, comma or blanks, by the header line
  char decimal = 0;                ///< 0: a point, or a comma where the separator leaves it free
  std::string encoding = "utf-8";  ///< or "latin-1"
  std::string comment = "#";       ///< lines that begin so are no rows
  std::uintmax_t max_bytes = std::uintmax_t{256} << 20;  ///< of the content, unpacked
  /// Of the entry itself, without [defaults]: those of FormatKey that the file's format does not
  /// read are refused.
  std::vector<SaidKey> said = {};
  bool operator==(const ReadSettings&) const = default;
};

/// What is known of a recording beside its readings.
struct RecordingSource {
  std::string format;              ///< a name of kImporters
  UnitNames units = {};            ///< of position and force, as they were read
  std::vector<std::string> taken;  ///< of the file beside the rows: "columns t, x, y, z, f"
};

/// Signals of one press, drag or path in SI units as recorded: unfiltered, zero and contact
/// unknown. N position rows on one clock; M force rows on the same one or, with force_time_s, on
/// another.
struct RawRecording : RecordingSource {
  std::string name;                  ///< within the file, where it holds several; else empty
  std::vector<double> time_s;        ///< N; empty when the file has no clock
  Points position_m{0, 3};           ///< N x 3 of the tip; or none
  std::vector<double> travel_m;      ///< N along the inward direction; or none
  std::vector<double> force_time_s;  ///< M; empty: the position rows
  Points force_N{0, 3};              ///< M x 3 of the tool ON the body; or none
  std::vector<double> push_N;  ///< M along the inward direction, of the tool ON the body; or none
  Points torque_Nm{0, 3};      ///< M x 3 about the tip, of the tool ON the body; or none
  std::vector<std::size_t> line;  ///< N, in the file (1-based)
  std::optional<Vec3> contact_m;  ///< where the press began, where the file says it
  std::optional<Vec3> normal;     ///< inward unit, likewise
  std::string place = {};         ///< which one it is, of a recording of several places
  std::optional<Error> unread;    ///< why it could not be read, of several in a file: then empty

  Eigen::Index rows() const { return line.size(); }
  bool is_axial() const { return position_m.rows() == 0; }
};

}  // namespace palpate::importers
