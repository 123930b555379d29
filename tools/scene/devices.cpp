#include "tools/scene/devices.hpp"

#include "libfit/io/atomic_file.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

extern const char* const kDevicesToml;  // generated from data/devices.toml

namespace {

void add_devices(std::string_view text, const std::string& file,
                 std::vector<certify::Device>& rows) {
  const toml::table parsed = parse_toml(text, file, "Write it as data/devices.toml is written.");
  SceneTable root(parsed, "the table of devices", file);
  for (SceneTable& table : root.tables("device", "[[device]]")) {
    certify::Device row;
    row.name = table.text("name", "");
    row.max_force_N = table.quantity("max_force", Dimension::force, 0, 0, 1e4);
    row.max_stiffness_N_m = table.number("max_stiffness", 0, 0, 1e7);
    row.resolution_m = table.quantity("resolution", Dimension::length, 0, 0, 0.1);
    row.friction_N = table.quantity("friction", Dimension::force, 0, 0, 1e3);
    row.mass_kg = table.number("mass", 0, 0, 1e3);
    row.source = table.text("source", "");
    table.finish();
    rows.push_back(std::move(row));
  }
  root.finish();
}

}  // namespace

std::vector<certify::Device> read_devices(const std::filesystem::path& more) {
  std::vector<certify::Device> rows;
  add_devices(kDevicesToml, "data/devices.toml", rows);
  if (!more.empty()) add_devices(read_whole_file(more), more.string(), rows);
  return rows;
}

}  // namespace palpate::tools
