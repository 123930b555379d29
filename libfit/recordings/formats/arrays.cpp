// Data sets of an HDF5 file that the manifest names by path: N values each, N x 3 for a position or
// force that has one name, or "M(:,2)" for a column of a matrix. A `unit` attribute stands for the
// brackets of a text header.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

// A file whose data sets are known by name.
struct DataSetFile {
  const h5::Reader& reader;
  std::filesystem::path path;
  std::vector<std::string> names;

  Error error(const std::string& name, const std::string& what, const std::string& remedy) const {
    return Error(path.string() + (name.empty() ? "" : ":" + name), what, remedy);
  }
  std::string listed_names() const { return "There are: " + listed(names).substr(0, 300) + "."; }
};

// "M(:,2)": {"M", 2}; "t" and "/t": {"t", 0}.
std::pair<std::string, std::size_t> set_and_column(std::string name) {
  if (name.starts_with('/')) name.erase(0, 1);
  const std::size_t open = name.find("(:,");
  if (open == std::string::npos || !name.ends_with(')')) return {name, 0};
  const auto column = parse_number(name.substr(open + 3, name.size() - open - 4), '.');
  if (!column || !(*column >= 1) || *column > 1e6) return {name, 0};
  return {name.substr(0, open), static_cast<std::size_t>(*column)};
}

std::vector<double> values_of(const h5::Reader& file, const std::string& set, h5::Shape shape) {
  if (file.type_of(set).starts_with("float")) return file.numbers(set, h5::kAnyUnit, shape, true);
  const auto whole = file.integers(set, h5::kAnyUnit, shape);
  return {whole.begin(), whole.end()};
}

// The numbers of a column by its name, and the header that says their unit.
std::vector<double> column_of(const DataSetFile& file, const std::string& name,
                              std::string& header) {
  const auto [set, column] = set_and_column(name);
  if (!file.reader.has(set)) throw file.error(name, "data set is missing", file.listed_names());
  const h5::Shape shape = file.reader.shape_of(set);
  const std::size_t columns = std::max<std::size_t>(shape.columns, 1);
  if (shape.rows == 0) throw file.error(name, "is no array of real numbers", file.listed_names());
  if (column == 0 && columns > 1)
    throw file.error(name, fmt::format("is a matrix of {} columns", columns),
                     "Name one of them: \"" + set + "(:,1)\".");
  if (column > columns)
    throw file.error(name, fmt::format("has {} columns", columns), "Name one that is there.");
  header = set + " (" + file.reader.text_if_any(set, "unit") + ")";
  const std::vector<double> all = values_of(file.reader, set, shape);
  std::vector<double> values;
  for (std::size_t i = std::max<std::size_t>(column, 1) - 1; i < all.size(); i += columns)
    values.push_back(all[i]);
  return values;
}

// Throws Error for an array that has a number out of range or is of another length than the first,
// or when there is no row.
RawRecording recording_of_data_sets(const DataSetFile& file, const ReadSettings& given) {
  std::string taken;
  ReadSettings settings = with_named_columns(
      given, file.names,
      [&](const auto& what, const auto& remedy) { return file.error("", what, remedy); }, taken);
  for (auto* axes : {&settings.columns.position, &settings.columns.force, &settings.columns.torque})
    if (const std::string set = axes->size() == 1 ? set_and_column(axes->front()).first : "";
        !set.empty() && file.reader.has(set) && file.reader.shape_of(set).columns == 3)
      *axes = {set + "(:,1)", set + "(:,2)", set + "(:,3)"};
  const std::vector<Role> roles = roles_of(settings.columns);
  if (roles.empty())
    throw file.error("", "no data set is named",
                     "Name columns = { time = ..., depth = ..., force = ... } in the manifest. " +
                         file.listed_names());
  std::vector<std::vector<double>> columns;
  std::vector<double> factors;
  for (const Role& role : roles) {
    std::string header;
    columns.push_back(column_of(file, role.name, header));
    factors.push_back(factor_of(
        role, header, settings.units,
        [&](const auto& what, const auto& remedy) { return file.error(role.name, what, remedy); }));
  }
  const std::size_t before = columns[0].size();
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].size() != before)
      throw file.error(
          roles[c].name,
          fmt::format("has {} rows, {} has {}", columns[c].size(), roles[0].name, before),
          "Give columns of one length.");
  std::optional<double> first_tick;  // of clocks that count from a time long past
  for (std::size_t c = 0; c < columns.size(); ++c)
    if ((roles[c].meaning == Meaning::time || roles[c].meaning == Meaning::force_time) &&
        before > 0 && std::isfinite(columns[c][0]) && std::abs(columns[c][0]) > kLargestNumber) {
      first_tick = first_tick.value_or(columns[c][0]);
      for (double& tick : columns[c]) tick -= *first_tick;
    }
  std::vector<std::size_t> line;
  for (std::size_t i = 0; i < before; ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (!(std::abs(columns[c][i]) <= kLargestNumber))
        throw file.error(roles[c].name, fmt::format("row {} is not a number in range", i + 1),
                         kBadRowRemedy);
    line.push_back(i + 1);
  }
  if (line.empty()) throw file.error(roles[0].name, "has no row of numbers", kNoRowRemedy);
  RawRecording recording =
      recording_of(roles, std::move(columns), factors, std::move(line), settings);
  if (!taken.empty()) recording.taken.push_back(taken);
  return recording;
}

}  // namespace

bool begins_hdf5(std::string_view head) { return head.starts_with("\x89HDF\r\n\x1a\n"); }

std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path& path, std::string_view,
                                            const ReadSettings& settings) {
  const h5::Reader file(
      path,
      "Name its data sets under `columns` of the manifest, and correct or remove unusable rows.");
  return {recording_of_data_sets({file, path, file.data_sets()}, settings)};
}

}  // namespace palpate::importers
