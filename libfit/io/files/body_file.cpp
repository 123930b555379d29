#include "libfit/io/files/files.hpp"

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

template <class Matrix>
void check_cells(const h5::Complain& complain, const std::string& name, const Matrix& cells,
                 Eigen::Index nodes) {
  check_indices(complain, name, cells.data(), cells.rows(), cells.cols(), nodes);
}

void check_test_points(const TestPoints& points, const h5::Complain& complain) {
  check_finite(complain, "test_points/position", points.position);
  check_rows(complain, "test_points/normal", points.normal.rows(), points.position.rows());
  check_unit_length(complain, "test_points/normal", points.normal);
  check_rows(complain, "test_points/name", static_cast<Eigen::Index>(points.name.size()),
             points.position.rows());
  check_cells(complain, "test_points/triangles", points.triangles, points.position.rows());
}

void check_volume(const Body& body, const h5::Complain& complain) {
  check_finite(complain, "volume/nodes", body.volume.nodes);
  check_cells(complain, "volume/tets", body.volume.tets, body.volume.nodes.rows());
  if (body.volume.region.size() != 0)
    check_rows(complain, "volume/region", body.volume.region.size(), body.volume.tets.rows());
  if (body.volume.region.size() != 0 && body.volume.region.minCoeff() < 0)
    throw complain("volume/region", "holds a negative region");
  check_flags(complain, "volume/is_held", body.is_held, body.volume.nodes.rows());
}

void check(const Body& body, const h5::Complain& complain) {
  check_finite(complain, "surface/vertices", body.surface.vertices);
  check_cells(complain, "surface/triangles", body.surface.triangles, body.surface.vertices.rows());
  check_flags(complain, "surface/is_reachable", body.is_reachable, body.surface.vertices.rows());
  check_test_points(body.test_points, complain);
  check_volume(body, complain);
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
  body.surface.vertices = read_points(reader, "surface/vertices", "m", h5::kAny);
  body.surface.triangles = read_triangles(reader, "surface/triangles", h5::kAny);
  body.is_reachable = read_flags(reader, "surface/is_reachable", h5::kAny);
  body.test_points.position = read_points(reader, "test_points/position", "m", h5::kAny);
  body.test_points.normal = read_points(reader, "test_points/normal", h5::kNoUnit, h5::kAny);
  body.test_points.name = reader.strings("test_points/name", h5::kAny);
  body.test_points.triangles = read_triangles(reader, "test_points/triangles", h5::kAny);
  body.volume.nodes = read_points(reader, "volume/nodes", "m", h5::kAny);
  const auto tets = reader.integers("volume/tets", h5::kNoUnit, {h5::kAny, 4});
  body.volume.tets =
      Eigen::Map<const Tets>(tets.data(), static_cast<Eigen::Index>(tets.size() / 4), 4);
  const auto region = reader.integers("volume/region", h5::kNoUnit, {h5::kAny, 0});
  body.volume.region =
      Eigen::Map<const Eigen::VectorXi>(region.data(), static_cast<Eigen::Index>(region.size()));
  body.is_held = read_flags(reader, "volume/is_held", h5::kAny);
  body.mended = reader.strings("mended", h5::kAny);
  body.probe = read_probe(reader);
  body.settings = read_settings(reader);
  check(body, complain_about(reader));
  return body;
}

void write_body(const std::filesystem::path& path, const Body& body, const Attributes& attributes) {
  check(body, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kBodySchema, attributes);
  write_points(writer, "surface/vertices", "m", body.surface.vertices);
  write_triangles(writer, "surface/triangles", body.surface.triangles);
  write_flags(writer, "surface/is_reachable", body.is_reachable);
  write_points(writer, "test_points/position", "m", body.test_points.position);
  write_points(writer, "test_points/normal", h5::kNoUnit, body.test_points.normal);
  writer.strings("test_points/name", body.test_points.name);
  write_triangles(writer, "test_points/triangles", body.test_points.triangles);
  write_points(writer, "volume/nodes", "m", body.volume.nodes);
  writer.integers("volume/tets", h5::kNoUnit, body.volume.tets.data(),
                  {static_cast<std::size_t>(body.volume.tets.rows()), 4});
  writer.integers("volume/region", h5::kNoUnit, body.volume.region.data(),
                  {static_cast<std::size_t>(body.volume.region.size()), 0});
  write_flags(writer, "volume/is_held", body.is_held);
  writer.strings("mended", body.mended);
  write_probe(writer, body.probe, complain_about(path));
  write_settings(writer, body.settings);
  writer.commit();
}

}  // namespace palpate
