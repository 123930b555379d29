#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/io/atomic_file.hpp"

namespace palpate {

/// A column that a reader knows. name carries the unit ("x_m"; "nx" and "path" have none).
struct CsvColumnRule {
  std::string_view name;
  bool is_required = true;
  bool is_text = false;
};

struct CsvColumn {
  std::string name;
  std::vector<double> number;     ///< a row each, unless the rule says text
  std::vector<std::string> text;  ///< a row each, when the rule says text
};

/// A table read by `read_csv`: the known columns found, in the order of the rules.
struct CsvTable {
  std::filesystem::path path;
  std::vector<CsvColumn> columns;
  std::vector<std::string> ignored;  ///< header names that no rule knows
  std::vector<std::size_t> line;     ///< 1-based line of each row

  std::size_t rows() const { return line.size(); }
  bool has(std::string_view name) const;
  /// Precondition: `has(name)`, and the rule says number (text).
  const std::vector<double>& number(std::string_view name) const;
  const std::vector<std::string>& text(std::string_view name) const;
};

/// Reads one of our own comma-separated tables (RFC 4180 quotes, no line breaks inside a field).
/// Byte-order mark, CRLF, blank lines and spaces around fields are accepted. Columns may come in
/// any order. Throws Error naming file, line and column when a required column is missing, a column
/// lacks its unit or carries another one (`x` or `x_mm` for `x_m`), a name comes twice, a row has
/// another number of fields than the header, something else than commas separates the names, or a
/// number is not one, not finite or out of range. Safe on untrusted bytes.
CsvTable read_csv(const std::filesystem::path& path, std::span<const CsvColumnRule> rules);

/// Writes a table row by row, stored whole or not at all (AtomicFile). Numbers read back to the
/// same double, in the fewest digits.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& path, std::span<const std::string_view> header);

  /// Fields of the current row, from left to right. NaN and inf throw Error: readers refuse them.
  CsvWriter& number(double value);
  CsvWriter& integer(long long value);
  CsvWriter& text(std::string_view value);
  void end_row();
  void commit();

 private:
  void separate();

  std::filesystem::path path_;
  AtomicFile file_;
  std::size_t columns_, field_ = 0, row_ = 0;
  std::string line_;
};

}  // namespace palpate
