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

void check(const Body& body, const h5::Complain& complain) {
  ColumnChecker all(complain);
  columns(body, all);
  check_indices(complain, "surface/triangles", body.surface.triangles,
                body.surface.vertices.rows());
  const TestPoints& points = body.test_points;
  check_unit_length(complain, "test_points/normal", points.normal);
  check_indices(complain, "test_points/triangles", points.triangles, points.position.rows());
  const TetMesh& volume = body.volume;
  check_indices(complain, "volume/tets", volume.tets, volume.nodes.rows());
  if (volume.region.size() == 0) return;
  check_rows(complain, "volume/region", volume.region.size(), volume.tets.rows());
  if (volume.region.minCoeff() < 0) throw complain("volume/region", "holds a negative region");
}

std::string mesh_group(std::size_t i) { return "scene/mesh_" + std::to_string(i) + "/"; }

template <class M, class F>
void mesh_columns(const std::string& group, M& mesh, F& f) {
  f.first(group + "vertices", mesh.vertices, {"m"});
  f.first(group + "triangles", mesh.triangles);
  f.first(group + "tets", mesh.tets);
  f.first(group + "is_painted", mesh.is_painted);
}

void check(const SceneMesh& mesh, const std::string& group, const h5::Complain& complain) {
  ColumnChecker all(complain);
  mesh_columns(group, mesh, all);
  check_indices(complain, group + "triangles", mesh.triangles, mesh.vertices.rows());
  check_indices(complain, group + "tets", mesh.tets, mesh.vertices.rows());
  if (!mesh.is_painted.empty())
    check_rows(complain, group + "is_painted", static_cast<Eigen::Index>(mesh.is_painted.size()),
               mesh.tets.rows() > 0 ? mesh.tets.rows() : mesh.triangles.rows());
}

void check_all(const Body& body, const h5::Complain& complain) {
  check(body, complain);
  for (std::size_t i = 0; i < body.scene_meshes.size(); ++i)
    check(body.scene_meshes[i], mesh_group(i), complain);
}

void read_scene(const h5::Reader& reader, Body& body) {
  if (!reader.has("scene/text")) return;
  body.scene = reader.strings("scene/text", 1).front();
  ColumnReader in(reader);
  for (std::size_t i = 0; reader.has(mesh_group(i) + "vertices"); ++i)
    mesh_columns(mesh_group(i), body.scene_meshes.emplace_back(), in);
}

void write_scene(h5::Writer& writer, const Body& body) {
  if (body.scene.empty()) return;
  writer.strings("scene/text", {body.scene});
  ColumnWriter out(writer);
  for (std::size_t i = 0; i < body.scene_meshes.size(); ++i)
    mesh_columns(mesh_group(i), body.scene_meshes[i], out);
}

}  // namespace

Body read_body(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kBodySchema);
  Body body;
  ColumnReader in(reader);
  columns(body, in);
  body.probe = read_probe(reader);
  read_scene(reader, body);
  check_all(body, complain_about(reader));
  return body;
}

void write_body(const std::filesystem::path& path, const Body& body, const Attributes& attributes) {
  check_all(body, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kBodySchema, attributes);
  ColumnWriter out(writer);
  columns(body, out);
  write_probe(writer, body.probe, complain_about(path));
  write_scene(writer, body);
  writer.commit();
}

}  // namespace palpate
