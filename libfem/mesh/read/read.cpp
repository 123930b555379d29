#include "libfem/mesh/read/read.hpp"

#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

using mesh_read::Cursor;

struct Format {
  std::string_view extension;
  bool has_tets;
  std::string_view what;
  mesh_read::RawMesh (*read)(Cursor& file, mesh_read::RawLabels* labels);
};

// Adding a format is a .cpp and a row.
constexpr Format kFormats[] = {
    {".obj", false, "Wavefront", mesh_read::read_obj},
    {".stl", false, "stereolithography, ASCII or binary", mesh_read::read_stl},
    {".ply", false, "Stanford, ASCII or binary", mesh_read::read_ply},
    {".off", false, "Geomview", mesh_read::read_off},
    {".vtk", false, "VTK legacy POLYDATA, ASCII or binary", mesh_read::read_vtk_polydata},
    {".msh", true, "Gmsh 1, 2.x or 4.1, ASCII or binary", mesh_read::read_msh},
    {".vtk", true, "VTK legacy UNSTRUCTURED_GRID, ASCII or binary", mesh_read::read_vtk_grid},
};

std::string list_formats(bool has_tets) {
  std::string list;
  for (const Format& row : kFormats)
    if (row.has_tets == has_tets)
      list += (list.empty() ? "" : ", ") + std::string(row.extension) + " (" +
              std::string(row.what) + ")";
  return list;
}

const Format* find_format(const std::string& extension, bool has_tets) {
  for (const Format& row : kFormats)
    if (row.has_tets == has_tets && mesh_read::same_word(row.extension, extension)) return &row;
  return nullptr;
}

void check_unit(double length_unit_m, const std::string& where) {
  if (!(length_unit_m > 0) || !std::isfinite(length_unit_m))
    throw Error(where, "the length unit is not a positive length in m",
                "Give the mesh's unit, e.g. length_unit = \"mm\".");
}

void check_size(const Points& points, const std::string& where) {
  const double largest = points.cwiseAbs().maxCoeff(), extent = extent_m(points).maxCoeff();
  const char* remedy = "Check length_unit, and the mesh for stray vertices.";
  if (largest > 1e6) throw Error(where, "the mesh reaches further than 1000 km", remedy);
  // A body of more than 1000 km or less than 1 nm is a wrong unit or misread bytes.
  if (extent < 1e-9) throw Error(where, "the mesh is smaller than 1 nm", remedy);
}

}  // namespace

namespace mesh_read {

RawMesh read_raw(const std::filesystem::path& path, bool is_tets, RawLabels* labels) {
  const std::string extension = path.extension().string();
  const Format* format = find_format(extension, is_tets);
  if (std::error_code ignored; !format && std::filesystem::is_directory(path, ignored))
    throw Error(path.string(), "is a folder", "Give the path of a mesh file.");
  if (!format)
    throw Error(path.string(),
                "'" + extension + "' is " +
                    (!find_format(extension, !is_tets) ? "no mesh format that is known here"
                     : is_tets ? "a format of surfaces, which are read as body.surface"
                               : "a format of tetrahedra, which are read as body.tetmesh"),
                "Known: " + list_formats(is_tets) + ". Gmsh and meshio convert others.");
  const std::string bytes = load_file(path);
  Cursor file(bytes, path.string());
  RawMesh mesh = format->read(file, labels);
  if (mesh.points.size() > std::size_t{std::numeric_limits<std::int32_t>::max()})
    throw Error(path.string(), "has more than 2^31 - 1 vertices", "Decimate the mesh.");
  return mesh;
}

}  // namespace mesh_read

Surface read_surface(const std::filesystem::path& path, double length_unit_m) {
  const std::string where = path.string();
  check_unit(length_unit_m, where);
  const auto raw = mesh_read::read_raw(path, false, nullptr);
  if (raw.triangles.empty())
    throw Error(where, "the mesh has no faces (" + std::to_string(raw.points.size()) + " vertices)",
                "Export the surface as triangles or polygons.");
  Surface surface{length_unit_m * rows_of(raw.points), rows_of(raw.triangles)};
  check_size(surface.vertices, where);
  return surface;
}

TetMesh read_tet_mesh(const std::filesystem::path& path, double length_unit_m,
                      TetReadNotes* notes) {
  const std::string where = path.string();
  check_unit(length_unit_m, where);
  auto raw = mesh_read::read_raw(path, true, nullptr);
  if (raw.tets.empty())
    throw Error(where,
                "the mesh has no tetrahedra (" + std::to_string(raw.ignored_elements) +
                    " points, lines and faces)",
                "Save the volume elements too, or a surface, read as body.surface, in one of: " +
                    list_formats(false) + ".");
  TetReadNotes own;
  TetMesh mesh = mesh_read::settle_tets(std::move(raw), length_unit_m, where, notes ? *notes : own);
  check_size(mesh.nodes, where);
  return mesh;
}

bool is_volume_format(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return find_format(extension, true) != nullptr && find_format(extension, false) == nullptr;
}

std::vector<MeshGroup> groups_of_tet_mesh(const std::filesystem::path& path) {
  mesh_read::RawLabels labels;
  mesh_read::read_raw(path, true, &labels);
  std::vector<MeshGroup> out;
  for (const mesh_read::RawLabels::Group& group : labels.groups)
    if (group.dimension >= 2) out.push_back({group.name, group.dimension, group.cells.size()});
  return out;
}

std::string stated_frame(const std::filesystem::path& mesh_file) {
  const std::string bytes = mesh_read::load_file(mesh_file);
  // The longest header of 3D Slicer, that of PLY, is below 300 bytes.
  constexpr std::size_t kHeaderBytes = 1024;
  constexpr std::string_view kKey = "SPACE=";
  const std::string_view header = std::string_view(bytes).substr(0, kHeaderBytes);
  const std::size_t at = header.find(kKey);
  if (at == std::string_view::npos) return {};
  const std::string_view value = header.substr(at + kKey.size());
  return std::string(value.substr(0, value.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ")));
}

}  // namespace palpate
