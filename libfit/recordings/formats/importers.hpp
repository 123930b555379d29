#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/recording.hpp"

namespace palpate::importers {

/// A row of the table of recording formats.
struct Importer {
  std::string_view name;
  /// True if a file begins like this format (its first bytes, unpacked); nullptr: never chosen by
  /// itself.
  bool (*begins)(std::string_view head);
  /// The recordings of a file. bytes: its content, unpacked. Throws Error naming file and line.
  std::vector<RawRecording> (*read)(const std::filesystem::path& path, std::string_view bytes,
                                    const ReadSettings& settings);
};

/// All formats, in the order in which a file is tried; "csv" takes what no other takes.
std::span<const Importer> importers();

/// The row of a name, nullptr when there is none.
const Importer* importer_named(std::string_view name);

/// A key of a recording's entry that some formats alone read.
struct FormatKey {
  std::string_view name;     ///< as in the manifest: "separator", "columns.normal"
  std::string_view formats;  ///< that read it, with blanks between
  std::string_view remedy;   ///< for other formats
};

std::span<const FormatKey> format_keys();

/// The key's row; nullptr of a key that every format reads.
const FormatKey* format_key(std::string_view name);

/// Bytes of a recording's file as it lies there. Throws Error when it is missing, cannot be read or
/// is larger than `max_bytes`; nothing of a larger file is read.
std::string read_bytes(const std::filesystem::path& path, std::uintmax_t max_bytes);

/// Takes bytes apart that are gzip, and leaves others as they are. Throws Error when they are
/// damaged or unpack to more than `max_bytes`.
std::string unpacked(const std::filesystem::path& path, std::string bytes,
                     std::uintmax_t max_bytes);

/// Takes one stream of zlib or gzip members apart, never more than `max_bytes`. Throws Error saying
/// that the file `is_damaged`, or that it holds more.
std::string inflated(const std::filesystem::path& path, std::string_view packed,
                     std::uintmax_t max_bytes, const std::string& is_damaged);

/// Reads once in a process of its own, whose result is dropped. Throws Error where that process
/// crashes or takes a minute of CPU time; what `read` throws is left to the second reading.
void rehearse(const std::filesystem::path& path, const std::function<void()>& read);

/// The recordings in the content of a file by its format, or by the format it begins like.
/// Every recording has at least one row, or of several says why it is unread; all numbers are
/// finite and within 1e15 of zero. Each names the format and what was taken from the file. Safe on
/// untrusted bytes: what the HDF5 library reads is rehearsed, one file at a time.
std::vector<RawRecording> read_recordings(const std::filesystem::path& path, std::string_view bytes,
                                          const ReadSettings& settings);

// Lines, fields and numbers of a rig's text file. Safe on untrusted bytes.

inline constexpr std::size_t kHeaderLines = 400;  ///< a preamble is shorter
inline constexpr double kLargestNumber = 1e15;    ///< beyond any rig; squares stay finite
inline constexpr const char* kNoRowRemedy = "Record it again, or remove it from the manifest.";
inline constexpr const char* kBadRowRemedy = "Correct or remove the row.";

/// A text file as lines in UTF-8, ended by LF, CRLF or CR in any mixture.
/// Throws Error naming file and line when it is empty, binary, or not in its encoding.
class TextFile {
 public:
  TextFile(const std::filesystem::path& path, std::string_view bytes, std::string_view encoding);

  std::size_t lines() const { return line_.size(); }
  std::string_view line(std::size_t index) const { return line_[index]; }
  Error error(std::size_t index, const std::string& what, const std::string& remedy) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::string converted_;  ///< holds the text when it had to be converted
  std::vector<std::string_view> line_;
};

/// True of a line that is blank or begins with the mark of a comment.
bool is_comment(std::string_view line, std::string_view mark);

/// True if bytes begin with the byte order mark of UTF-16.
bool is_utf16(std::string_view bytes);
/// Such text as UTF-8, without the mark. Throws Error naming the line where it is damaged.
std::string utf8_of(const std::filesystem::path& path, std::string_view bytes);

/// Without blanks and quotes around it.
std::string_view unquoted(std::string_view text);
/// Fields of a line, each trimmed; a separator ' ' stands for any run of blanks.
std::vector<std::string_view> split(std::string_view line, char separator);
/// True if a list with blanks between its words has this one.
bool has_word(std::string_view list, std::string_view word);
/// The separator of a header or data line: tab, semicolon, comma, else blanks.
char guess_separator(std::string_view line);
/// A finite number with this decimal sign and nothing else; nothing otherwise ("nan" included).
std::optional<double> parse_number(std::string_view text, char decimal);
/// A number without the signs between its groups of three digits, "1,304.5" where `group` is a
/// comma; nothing where there are none, or they stand elsewhere.
std::optional<std::string> without_groups(std::string_view text, char group);
/// True if a field has no value: it is blank, or "nan" as tables of other programs write that.
bool is_blank_field(std::string_view text);
/// "Load (N)" or "Load [N]" -> {"Load", "N"}; the micro sign becomes u. {name, ""} without
/// brackets.
std::pair<std::string, std::string> split_unit(std::string_view name);

/// Columns of numbers below a header line.
struct NumberTable {
  std::vector<std::vector<double>> column;  ///< as asked for
  std::vector<std::size_t> line;            ///< 1-based, of each row
};

/// Layout of a file's numbers.
struct TableLayout {
  std::size_t first = 0;  ///< index of the first data line
  char separator = ',';
  char decimal = '.';
  std::string_view comment;
  std::vector<std::size_t> field;   ///< of each column asked for
  std::vector<std::string> name;    ///< of each, for errors
  bool has_groups = false;          ///< "1,304" is 1304 where the decimal sign is a point
  std::vector<char> is_clock = {};  ///< of each, or empty
  /// Where clocks count beyond what a double resolves: the tick that they count from, of all tables
  /// of a file; none yet before the first.
  std::optional<std::int64_t>* first_tick = nullptr;
  bool shares_clock = false;  ///< nor are those with all but the clock without a value
};

/// Reads the asked columns until the last line. Throws Error naming file:line and column when a
/// field is missing, no number, not finite or beyond 1e15.
NumberTable read_numbers(const TextFile& file, const TableLayout& layout);

// From named columns to a recording: what tables and arrays have in common.

enum class Meaning { time, force_time, depth, position, force, contact, normal, torque };

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

/// The columns of a meaning side by side; no rows where it has none.
Points points_of(Meaning meaning, const std::vector<Role>& roles,
                 const std::vector<std::vector<double>>& columns);

/// A recording of columns in the file's units times `factors`. Precondition: lengths of `line`, but
/// for a force with a clock of its own.
RawRecording recording_of(const std::vector<Role>& roles, std::vector<std::vector<double>> columns,
                          const std::vector<double>& factors, std::vector<std::size_t> line,
                          const ReadSettings& settings);

// The rows' functions, each in the file of its name.
std::vector<RawRecording> read_columns_csv(const std::filesystem::path&, std::string_view,
                                           const ReadSettings&);
std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path&, std::string_view,
                                            const ReadSettings&);
std::vector<RawRecording> read_robot_palpation(const std::filesystem::path&, std::string_view,
                                               const ReadSettings&);
std::vector<RawRecording> read_matlab(const std::filesystem::path&, std::string_view,
                                      const ReadSettings&);
bool begins_matlab(std::string_view head);
bool begins_named_columns(std::string_view head);
bool begins_hdf5(std::string_view head);

}  // namespace palpate::importers
