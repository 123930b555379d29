// TetGen's pair of ASCII files: X.node (points) and X.ele (tets of 4 or 10 nodes).
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfit/core/error.hpp"

namespace palpate::mesh_read {
namespace {

// Returns the number of the first point, 0 or 1.
std::int64_t read_nodes(Cursor& file, RawMesh& mesh) {
  const std::size_t nodes = file.count(NumberType::int64, 8, "nodes");
  if (file.integer() != 3) file.fail("the points are not of dimension 3");
  file.line();
  std::int64_t first = 0;
  mesh.points.reserve(nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    const std::int64_t id = file.integer();
    if (n == 0) first = id;
    if (first < 0 || first > 1 || id != first + static_cast<std::int64_t>(n))
      file.fail("points are not numbered consecutively from 0 or 1");
    mesh.points.push_back(file.position_3d());
    file.line();  // attributes and boundary marker
  }
  return first;
}

void read_elements(Cursor& file, std::int64_t first, RawMesh& mesh) {
  const std::size_t tets = file.count(NumberType::int64, 10, "tetrahedra");
  const std::int64_t corners = file.integer();
  if (corners != 4 && corners != 10) file.fail("tetrahedra have neither 4 nor 10 nodes");
  file.line();
  for (std::size_t t = 0; t < tets; ++t) {
    const std::int64_t id = file.integer();
    std::array<std::int64_t, 4> corner;
    for (std::int64_t& c : corner) {
      c = file.integer();
      if (c < first)
        file.fail("a tetrahedron uses node " + std::to_string(c) + ", which is not there");
      c -= first;
    }
    add_tet(mesh, corner, id, file);
    file.line();  // further nodes and attributes
  }
}

}  // namespace

RawMesh read_tetgen(Cursor& file, RawLabels*) {
  const std::filesystem::path path(file.file());
  const bool is_node = same_word(path.extension().string(), ".node");
  std::filesystem::path other = path;
  other.replace_extension(is_node ? ".ele" : ".node");
  if (!std::filesystem::exists(other))
    throw Error(path.string(), "its other half, " + other.filename().string() + ", is missing",
                "TetGen writes X.node and X.ele as a pair; put both into one folder.");
  const std::string other_bytes = load_file(other);
  Cursor nodes(is_node ? file.bytes() : std::string_view(other_bytes),
               (is_node ? path : other).string());
  Cursor elements(is_node ? std::string_view(other_bytes) : file.bytes(),
                  (is_node ? other : path).string());
  nodes.comment = elements.comment = '#';
  RawMesh mesh;
  const std::int64_t first = read_nodes(nodes, mesh);
  read_elements(elements, first, mesh);
  return mesh;
}

}  // namespace palpate::mesh_read
