// Data sets of an HDF5 file that the manifest names by path: N values each, or N x 3 for a position
// or force given by one name. A `unit` attribute stands for the brackets of a text header.

#include <fmt/core.h>

#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

std::vector<double> values_of(const h5::Reader& file, const std::string& set, h5::Shape shape) {
  if (file.type_of(set).starts_with("float")) return file.numbers(set, h5::kAnyUnit, shape, true);
  const auto whole = file.integers(set, h5::kAnyUnit, shape);
  return {whole.begin(), whole.end()};
}

// One name for three axes becomes "name:0", "name:1", "name:2".
void expand(const h5::Reader& file, std::vector<std::string>& names) {
  if (names.size() != 1 || !file.has(names[0]) || file.shape_of(names[0]).columns != 3) return;
  const std::string set = names[0];
  names = {set + ":0", set + ":1", set + ":2"};
}

std::pair<std::string, std::size_t> set_and_axis(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  if (colon == std::string::npos || colon + 2 != name.size()) return {name, 0};
  return {name.substr(0, colon), static_cast<std::size_t>(name.back() - '0')};
}

std::vector<double> column_of(const h5::Reader& file, const std::string& name) {
  const auto [set, axis] = set_and_axis(name);
  const h5::Shape shape = file.shape_of(set);
  const auto values = values_of(file, set, shape);
  const std::size_t stride = shape.columns == 0 ? 1 : shape.columns;
  if (axis >= stride) throw file.error(set, fmt::format("has no column {}", axis));
  std::vector<double> column;
  for (std::size_t i = axis; i < values.size(); i += stride) column.push_back(values[i]);
  return column;
}

void strip_root(ColumnNames& names) {
  const auto strip = [](std::string& name) {
    if (name.starts_with('/')) name.erase(0, 1);
  };
  for (std::string* name :
       {&names.time, &names.depth, &names.force_time, &names.retract_depth, &names.retract_force})
    strip(*name);
  for (auto* axes : {&names.position, &names.force, &names.contact, &names.normal, &names.torque})
    for (std::string& name : *axes) strip(name);
}

}  // namespace

bool begins_hdf5(std::string_view head) { return head.starts_with("\x89HDF\r\n\x1a\n"); }

std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path& path, std::string_view,
                                            const ReadSettings& given) {
  const h5::Reader file(
      path,
      "Name its data sets under `columns` of the manifest, and correct or remove unusable rows "
      "(or import with --drop-invalid).");
  std::string taken;
  const ReadSettings settings = with_named_columns(
      given, file.data_sets(),
      [&](const std::string& what, const std::string& remedy) {
        return Error(path.string(), what, remedy);
      },
      taken);
  ColumnNames names = settings.columns;
  strip_root(names);
  expand(file, names.position), expand(file, names.force), expand(file, names.torque);
  const auto roles = roles_of(names);
  if (roles.empty()) throw file.error("", "no data set is named");
  std::vector<std::vector<double>> columns;
  std::vector<double> factors;
  for (const Role& role : roles) {
    const std::string set = set_and_axis(role.name).first;
    const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
      return Error(path.string() + ":" + set, what, remedy);
    };
    if (!file.has(set)) {
      std::string list;
      for (const std::string& other : file.data_sets()) list += (list.empty() ? "" : ", ") + other;
      throw fail("data set is missing", "There are: " + list.substr(0, 300) + ".");
    }
    columns.push_back(column_of(file, role.name));
    factors.push_back(
        factor_of(role, set + " (" + file.text_if_any(set, "unit") + ")", settings.units, fail));
  }
  RawRecording recording = recording_of_arrays(
      roles, std::move(columns), factors, settings,
      [&](const Role& role, const std::string& what, const std::string& remedy) {
        return Error(path.string() + ":" + set_and_axis(role.name).first, what, remedy);
      });
  if (!taken.empty()) recording.taken.push_back(taken);
  return {recording};
}

}  // namespace palpate::importers
