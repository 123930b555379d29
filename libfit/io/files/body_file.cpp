#include "libfit/io/files/files.hpp"

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

// B: Body or const Body.
template <class B, class F>
void columns(B& body, F& f) {
  f.first("surface/vertices", body.surface.vertices, {"m"});
  f("surface/in_region", body.in_region);
  f("surface/is_reachable", body.is_reachable);
  f.first("surface/triangles", body.surface.triangles);
  f.first("test_points/position", body.test_points.position, {"m"});
  f("test_points/normal", body.test_points.normal);
  f("test_points/name", body.test_points.name);
  f.first("test_points/triangles", body.test_points.triangles);
  f.first("volume/nodes", body.volume.nodes, {"m"});
  f("volume/is_held", body.is_held);
  f.first("volume/tets", body.volume.tets);
  f.first("volume/region", body.volume.region);
  f.first("mended", body.mended);
}

template <class Matrix>
void check_cells(const h5::Complain& complain, const std::string& name, const Matrix& cells,
                 Eigen::Index nodes) {
  check_indices(complain, name, cells.data(), cells.rows(), cells.cols(), nodes);
}

void check(const Body& body, const h5::Complain& complain) {
  RowChecker rows(complain);
  columns(body, rows);
  check_finite(complain, "surface/vertices", body.surface.vertices);
  check_cells(complain, "surface/triangles", body.surface.triangles, body.surface.vertices.rows());
  check_flags(complain, "surface/in_region", body.in_region);
  check_flags(complain, "surface/is_reachable", body.is_reachable);
  const TestPoints& points = body.test_points;
  check_finite(complain, "test_points/position", points.position);
  check_unit_length(complain, "test_points/normal", points.normal);
  check_cells(complain, "test_points/triangles", points.triangles, points.position.rows());
  const TetMesh& volume = body.volume;
  check_finite(complain, "volume/nodes", volume.nodes);
  check_cells(complain, "volume/tets", volume.tets, volume.nodes.rows());
  check_flags(complain, "volume/is_held", body.is_held);
  if (volume.region.size() == 0) return;
  check_rows(complain, "volume/region", volume.region.size(), volume.tets.rows());
  if (volume.region.minCoeff() < 0) throw complain("volume/region", "holds a negative region");
}

constexpr std::string_view kSettings = "settings/";

Settings read_settings(const h5::Reader& reader) {
  Settings settings;
  for (const std::string& name : reader.data_sets()) {
    if (!name.starts_with(kSettings)) continue;
    Setting& setting = settings[name.substr(kSettings.size())];
    if (reader.type_of(name) == "text") {
      setting.text = reader.strings(name, 1).front();
    } else {
      setting.unit = reader.unit_of(name);
      setting.numbers = reader.numbers(name, setting.unit, {h5::kAny, 0}, true);
    }
  }
  return settings;
}

void write_settings(h5::Writer& writer, const Settings& settings) {
  for (const auto& [key, setting] : settings) {
    const std::string name = std::string(kSettings) + key;
    if (setting.unit.empty())
      writer.strings(name, {setting.text});
    else
      writer.numbers(name, setting.unit, setting.numbers.data(), {setting.numbers.size(), 0});
  }
}

}  // namespace

Body read_body(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kBodySchema);
  Body body;
  ColumnReader in(reader);
  columns(body, in);
  body.probe = read_probe(reader);
  body.settings = read_settings(reader);
  check(body, complain_about(reader));
  return body;
}

void write_body(const std::filesystem::path& path, const Body& body, const Attributes& attributes) {
  check(body, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kBodySchema, attributes);
  ColumnWriter out(writer);
  columns(body, out);
  write_probe(writer, body.probe, complain_about(path));
  write_settings(writer, body.settings);
  writer.commit();
}

}  // namespace palpate
