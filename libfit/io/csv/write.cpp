#include <array>
#include <cassert>
#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/csv/csv.hpp"

namespace palpate {
namespace {

std::string quoted_if_needed(std::string_view value) {
  const bool is_plain = value.find_first_of(",\" \t") == std::string_view::npos && !value.empty();
  if (is_plain) return std::string(value);
  std::string text = "\"";
  for (const char c : value) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + '"';
}

}  // namespace

CsvWriter::CsvWriter(const std::filesystem::path& path, std::span<const std::string_view> header)
    : path_(path), file_(path), columns_(header.size()) {
  for (const std::string_view name : header) text(name);
  end_row();
  row_ = 0;
}

void CsvWriter::separate() {
  assert(field_ < columns_);
  if (field_++ > 0) line_ += ',';
}

CsvWriter& CsvWriter::number(double value) {
  if (!std::isfinite(value))
    throw Error(path_.string(),
                "row " + std::to_string(row_) + " field " + std::to_string(field_ + 1) +
                    " would not be a finite number",
                "Not written; report how it was made.");
  separate();
  line_ += to_text(value);
  return *this;
}

CsvWriter& CsvWriter::integer(long long value) {
  separate();
  line_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::text(std::string_view value) {
  if (value.find_first_of("\r\n") != std::string_view::npos)
    throw Error(path_.string(), "a text field holds a line break", "Take it out of the name.");
  separate();
  line_ += quoted_if_needed(value);
  return *this;
}

void CsvWriter::end_row() {
  assert(field_ == columns_);
  line_ += '\n';
  file_.write(line_);
  line_.clear();
  field_ = 0;
  ++row_;
}

void CsvWriter::commit() { file_.commit(); }

}  // namespace palpate
