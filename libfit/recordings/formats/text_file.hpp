#pragma once

#include <string_view>

#include "libfit/recordings/formats/recording.hpp"

// Lines, fields and numbers of a rig's text file, for the importers alone. Safe on untrusted bytes.

namespace palpate::importers {

inline constexpr std::size_t kHeaderLines = 400;  ///< a preamble is shorter
inline constexpr double kLargestNumber = 1e15;    ///< beyond any rig; squares stay finite
inline constexpr const char* kNoRowRemedy = "Record it again, or remove it from the manifest.";
inline constexpr const char* kBadRowRemedy =
    "Correct or remove the row, or import with --drop-invalid to skip and count such rows.";

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

/// Whether bytes begin with the byte order mark of UTF-16.
bool is_utf16(std::string_view bytes);
/// Such text as UTF-8, without the mark. Throws Error naming the line where it is damaged.
std::string utf8_of(const std::filesystem::path& path, std::string_view bytes);

/// Without blanks and quotes around it.
std::string_view unquoted(std::string_view text);
/// Fields of a line, each trimmed; a separator ' ' stands for any run of blanks.
std::vector<std::string_view> split(std::string_view line, char separator);
/// Whether a list with blanks between its words has this one.
bool has_word(std::string_view list, std::string_view word);
/// The separator of a header or data line: tab, semicolon, comma, else blanks.
char guess_separator(std::string_view line);
/// A finite number with this decimal sign and nothing else; nothing otherwise ("nan" included).
std::optional<double> parse_number(std::string_view text, char decimal);
/// A number without the signs between its groups of three digits, "1,304.5" where `group` is a
/// comma; nothing where there are none, or they stand elsewhere.
std::optional<std::string> without_groups(std::string_view text, char group);
/// Whether a field has no value: it is blank, or "nan" as tables of other programs write that.
bool is_blank_field(std::string_view text);
/// "Load (N)" or "Load [N]" -> {"Load", "N"}; the micro sign becomes u. {name, ""} without
/// brackets.
std::pair<std::string, std::string> split_unit(std::string_view name);

/// Columns of numbers below a header line.
struct NumberTable {
  std::vector<std::vector<double>> column;  ///< as asked for
  std::vector<std::size_t> line;            ///< 1-based, of each row
  std::size_t dropped_rows = 0;
};

/// How the numbers of a file are laid out.
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
  bool may_end_early = false;  ///< rows with every asked field empty are no rows
  bool shares_clock = false;   ///< nor are those with all but the clock without a value
  bool drop_invalid = false;
};

/// Reads the asked columns until the last line. Throws Error naming file:line and column when a
/// field is missing, no number, not finite or beyond 1e15; with drop_invalid such rows are counted
/// instead.
NumberTable read_numbers(const TextFile& file, const TableLayout& layout);

}  // namespace palpate::importers
