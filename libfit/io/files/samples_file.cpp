#include "libfit/io/files/samples_file.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/columns.hpp"
#include "libfit/io/files/measured_columns.hpp"
#include "libfit/io/files/probe_group.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr int kExperimentKinds = 3;

std::size_t rows_of(const Samples& samples) { return samples.point.size(); }

template <class Integer>
std::string row_name(Integer row) {
  return "row " + std::to_string(row);
}

void check_sizes(const Samples& s, const h5::Complain& complain) {
  const Eigen::Index points = s.points(), rows = static_cast<Eigen::Index>(rows_of(s));
  const auto size = [](const auto& column) { return static_cast<Eigen::Index>(column.size()); };
  check_rows(complain, "points/normal", s.point_normal.rows(), points);
  check_rows(complain, "points/name", size(s.point_name), points);
  if (s.point_normal_gradient.rows() != 0)
    check_rows(complain, "points/normal_gradient", s.point_normal_gradient.rows(), points);
  check_rows(complain, "rows/experiment", size(s.experiment), rows);
  check_rows(complain, "rows/kind", size(s.kind), rows);
  check_rows(complain, "rows/step", size(s.step), rows);
  check_rows(complain, "rows/deflection", s.deflection.rows(), rows);
  check_rows(complain, "rows/force", s.force.rows(), rows);
  check_rows(complain, "rows/torque", s.torque.rows(), rows);
  check_rows(complain, "rows/force_error", s.force_error.size(), rows);
  check_rows(complain, "rows/status", size(s.status), rows);
  if (!s.doubt.empty()) check_rows(complain, "rows/doubt", size(s.doubt), rows);
}

void check_numbers(const Samples& s, const h5::Complain& complain) {
  check_finite(complain, "points/position", s.point_position);
  check_unit_length(complain, "points/normal", s.point_normal);
  if (!s.point_normal_gradient.allFinite())
    throw complain("points/normal_gradient", "is not finite");
  check_finite(complain, "rows/deflection", s.deflection);
  for (Eigen::Index i = 0; i < s.rows(); ++i) {
    const bool is_good = s.status[static_cast<std::size_t>(i)] == RowStatus::good;
    if (is_good && !s.force.row(i).allFinite())
      throw complain("rows/force", row_name(i) + " is good but not a finite number");
    if (is_good && !s.torque.row(i).allFinite())
      throw complain("rows/torque", row_name(i) + " is good but not a finite number");
    if (s.force_error[i] < 0) throw complain("rows/force_error", row_name(i) + " is negative");
  }
}

// Rows of an experiment follow one another and share point and kind.
void check_experiments(const Samples& s, const h5::Complain& complain) {
  std::unordered_set<std::int32_t> finished;
  for (std::size_t i = 1; i < rows_of(s); ++i) {
    if (s.experiment[i] != s.experiment[i - 1]) {
      finished.insert(s.experiment[i - 1]);
      if (finished.count(s.experiment[i]) != 0)
        throw complain("rows/experiment",
                       row_name(i) + " goes back to experiment " + std::to_string(s.experiment[i]));
    } else if (s.point[i] != s.point[i - 1] || s.kind[i] != s.kind[i - 1]) {
      throw complain("rows/experiment", row_name(i) + " changes point or kind within experiment " +
                                            std::to_string(s.experiment[i]));
    }
  }
}

void check(const Samples& s, const h5::Complain& complain) {
  check_sizes(s, complain);
  check_indices(complain, "rows/point", s.point.data(), static_cast<Eigen::Index>(rows_of(s)), 1,
                s.points());
  check_numbers(s, complain);
  check_experiments(s, complain);
  check_measured(s.recordings, complain);
}

template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return names;
}

// Codes of a column and what they mean by the file's own list of names; without a list, by `table`.
// `member` is the table's column of values.
template <class Row, std::size_t Count, class Enum>
std::vector<Enum> read_named(const h5::Reader& reader, const std::string& column, std::size_t rows,
                             const std::array<Row, Count>& table, Enum Row::*member,
                             const h5::Rows& wanted) {
  const auto codes = reader.bytes(column, h5::kNoUnit, {rows, 0}, wanted);
  const auto names = reader.has_attribute(column, "names") ? reader.texts_attribute(column, "names")
                                                           : names_of(table);
  std::vector<Enum> meanings, out;
  for (const auto& name : names) {
    const auto row = std::find_if(table.begin(), table.end(),
                                  [&](const Row& known) { return known.name == name; });
    if (row == table.end()) throw reader.error(column, "names an unknown code `" + name + "`");
    meanings.push_back((*row).*member);
  }
  for (const std::int8_t code : codes) {
    if (code < 0 || static_cast<std::size_t>(code) >= meanings.size())
      throw reader.error(column, "row " + std::to_string(out.size()) + " has code " +
                                     std::to_string(code) + " without a name");
    out.push_back(meanings[static_cast<std::size_t>(code)]);
  }
  return out;
}

std::vector<ExperimentKind> read_kind(const h5::Reader& reader, std::size_t rows,
                                      const h5::Rows& wanted) {
  std::vector<ExperimentKind> kinds;
  for (const std::int8_t code : reader.bytes("rows/kind", h5::kNoUnit, {rows, 0}, wanted)) {
    if (code < 0 || code >= kExperimentKinds)
      throw reader.error("rows/kind", "row " + std::to_string(kinds.size()) + " has code " +
                                          std::to_string(code) + ", not 0 press, 1 drag, 2 path");
    kinds.push_back(static_cast<ExperimentKind>(code));
  }
  return kinds;
}

void read_points_of(const h5::Reader& reader, Samples& s) {
  s.point_position = read_points(reader, "points/position", "m", h5::kAny);
  const auto points = static_cast<std::size_t>(s.points());
  s.point_normal = read_points(reader, "points/normal", h5::kNoUnit, points);
  s.point_name = reader.strings("points/name", points);
  s.probe = read_probe(reader);
  if (reader.has("body/poisson"))
    s.poisson = reader.numbers("body/poisson", h5::kNoUnit, {1, 0}).front();
  if (!reader.has("points/normal_gradient")) return;
  const auto values = reader.numbers("points/normal_gradient", "1/m", {points, 9});
  s.point_normal_gradient =
      Eigen::Map<const decltype(s.point_normal_gradient)>(values.data(), s.points(), 9);
}

void read_rows(const h5::Reader& reader, const h5::Rows& wanted, Samples& s) {
  const std::size_t rows = reader.shape_of("rows/point").rows;
  s.point = reader.integers("rows/point", h5::kNoUnit, {rows, 0}, wanted);
  s.experiment = reader.integers("rows/experiment", h5::kNoUnit, {rows, 0}, wanted);
  s.kind = read_kind(reader, rows, wanted);
  s.step = reader.integers("rows/step", h5::kNoUnit, {rows, 0}, wanted);
  s.deflection = read_points(reader, "rows/deflection", "m", rows, false, wanted);
  s.force = read_points(reader, "rows/force", "N", rows, true, wanted);
  s.torque = read_points(reader, "rows/torque", "N m", rows, true, wanted);
  s.force_error = read_vector(reader, "rows/force_error", "N", rows, true, wanted);
  s.status =
      read_named(reader, "rows/status", rows, kRowStatusNames, &RowStatusName::status, wanted);
  if (reader.has("rows/doubt"))
    s.doubt =
        read_named(reader, "rows/doubt", rows, kStepCheckNames, &StepCheckName::doubt, wanted);
}

template <class Enum>
void write_codes(h5::Writer& writer, const std::string& name, const std::vector<Enum>& values) {
  std::vector<std::int8_t> codes;
  for (const Enum value : values) codes.push_back(static_cast<std::int8_t>(value));
  writer.bytes(name, h5::kNoUnit, codes.data(), {codes.size(), 0});
}

// Data sets whose stored bytes an index of the rows answers for.
constexpr std::string_view kIndexed[] = {"rows/point",
                                         "rows/experiment",
                                         "rows/kind",
                                         "rows/step",
                                         "rows/deflection",
                                         "rows/force",
                                         "rows/force_error",
                                         "rows/status",
                                         "points/first_row",
                                         "points/row_count",
                                         "points/first_experiment",
                                         "points/rows_hash"};
constexpr const char* kIndexOf = "stored_hash";  // attribute of points/rows_hash

// of: gives the hash of a data set's stored bytes.
template <class File>
std::string stored_hash_of_rows(const File& file) {
  std::string all;
  for (const std::string_view name : kIndexed)
    all += std::to_string(file.stored_hash(std::string(name))) + ' ';
  return content_hash(all);
}

void write_index(h5::Writer& writer, const Samples& s) {
  const RowIndex index = index_rows(s);
  if (!index.is_contiguous) return;
  const h5::Shape column{index.hash.size(), 0};
  writer.integers("points/first_row", h5::kNoUnit, index.first_row.data(), column);
  writer.integers("points/row_count", h5::kNoUnit, index.row_count.data(), column);
  writer.integers("points/first_experiment", h5::kNoUnit, index.first_experiment.data(), column);
  writer.strings("points/rows_hash", index.hash);
  writer.attribute("points/rows_hash", kIndexOf, stored_hash_of_rows(writer));
}

}  // namespace

Samples read_samples(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSamplesSchema);
  Samples s;
  read_points_of(reader, s);
  read_rows(reader, std::nullopt, s);
  s.recordings = read_measured(reader);
  check(s, complain_about(reader));
  return s;
}

std::optional<IndexedSamples> read_samples_index(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSamplesSchema);
  if (!reader.has("points/rows_hash") || !reader.has_attribute("points/rows_hash", kIndexOf))
    return std::nullopt;
  for (const std::string_view name : kIndexed)
    if (!reader.has(std::string(name))) return std::nullopt;
  if (reader.text_attribute("points/rows_hash", kIndexOf) != stored_hash_of_rows(reader))
    return std::nullopt;
  IndexedSamples out;
  read_points_of(reader, out.points);
  const auto points = static_cast<std::size_t>(out.points.points());
  out.index.first_row = reader.integers("points/first_row", h5::kNoUnit, {points, 0});
  out.index.row_count = reader.integers("points/row_count", h5::kNoUnit, {points, 0});
  out.index.first_experiment = reader.integers("points/first_experiment", h5::kNoUnit, {points, 0});
  out.index.hash = reader.strings("points/rows_hash", points);
  out.rows = reader.shape_of("rows/point").rows;
  check_sizes(out.points, complain_about(reader));
  check_numbers(out.points, complain_about(reader));
  return out;
}

Samples read_samples_of(const std::filesystem::path& path, const IndexedSamples& indexed,
                        const std::vector<char>& is_wanted) {
  const h5::Reader reader = h5::open(path, kSamplesSchema);
  std::vector<h5::RowRange> ranges;
  for (std::size_t p = 0; p < is_wanted.size(); ++p) {
    const std::int32_t first = indexed.index.first_row[p], count = indexed.index.row_count[p];
    if (first < 0 || count < 0) throw reader.error("points/first_row", "is negative");
    if (is_wanted[p] && count > 0)
      ranges.push_back({static_cast<std::size_t>(first), static_cast<std::size_t>(count)});
  }
  Samples s = indexed.points;
  read_rows(reader, ranges, s);
  check(s, complain_about(reader));
  return s;
}

void write_samples(const std::filesystem::path& path, const Samples& s,
                   const Attributes& attributes) {
  check(s, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kSamplesSchema, attributes);
  write_points(writer, "points/position", "m", s.point_position);
  write_points(writer, "points/normal", h5::kNoUnit, s.point_normal);
  writer.strings("points/name", s.point_name);
  if (s.point_normal_gradient.rows() != 0)
    writer.numbers("points/normal_gradient", "1/m", s.point_normal_gradient.data(),
                   {s.point_name.size(), 9});
  const h5::Shape column{rows_of(s), 0};
  writer.integers("rows/point", h5::kNoUnit, s.point.data(), column);
  writer.integers("rows/experiment", h5::kNoUnit, s.experiment.data(), column);
  write_codes(writer, "rows/kind", s.kind);
  writer.integers("rows/step", h5::kNoUnit, s.step.data(), column);
  write_points(writer, "rows/deflection", "m", s.deflection);
  write_points(writer, "rows/force", "N", s.force);
  write_points(writer, "rows/torque", "N m", s.torque);
  write_vector(writer, "rows/force_error", "N", s.force_error);
  write_codes(writer, "rows/status", s.status);
  writer.attribute("rows/status", "names", names_of(kRowStatusNames));
  if (!s.doubt.empty()) {
    write_codes(writer, "rows/doubt", s.doubt);
    writer.attribute("rows/doubt", "names", names_of(kStepCheckNames));
  }
  write_index(writer, s);
  write_probe(writer, s.probe, complain_about(path));
  if (!std::isnan(s.poisson)) writer.numbers("body/poisson", h5::kNoUnit, &s.poisson, {1, 0});
  write_measured(writer, s.recordings);
  writer.commit();
}

}  // namespace palpate
