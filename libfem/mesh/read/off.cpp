// Object File Format of Geomview: OFF and its variants with normals, colours and texture
// coordinates (COFF, NOFF, STOFF, CNOFF, ...), a vertex or face per line, # comments.

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

// Takes the keyword if there is one; true when vertices carry more than a position.
bool read_keyword(Cursor& file) {
  if (file.at_end()) file.fail("the file holds no data");
  const std::size_t start = file.position();
  const std::string_view keyword = file.word();
  if (!keyword.ends_with("OFF")) {
    file.seek(start);
    file.integer();  // counts without keyword are allowed; anything else is named
    file.seek(start);
    return false;
  }
  const std::string_view kind = keyword.substr(0, keyword.size() - 3);
  if (kind.find_first_not_of("STCN") != std::string_view::npos)
    file.fail("this variant of OFF is not in three dimensions", "Export a plain OFF file.");
  const std::size_t after = file.position();
  if (same_word(file.word_on_line(), "BINARY"))
    file.fail("binary OFF is not supported", "Export an ASCII OFF or a PLY file.");
  file.seek(after);
  return !kind.empty();
}

}  // namespace

RawMesh read_off(Cursor& file, RawLabels*) {
  file.comment = '#';
  const bool has_extras = read_keyword(file);
  const std::size_t vertices = file.count(NumberType::int64, 6, "vertices");
  const std::size_t faces = file.count(NumberType::int64, 8, "faces");
  file.line();  // the number of edges, which nobody keeps right

  RawMesh surface;
  surface.points.reserve(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    surface.points.push_back(file.position_3d());
    if (!has_extras && !file.word_on_line().empty())
      file.fail("a vertex line holds more than three numbers",
                "Name the variant (COFF, NOFF) in the first line.");
    file.line();
  }
  std::vector<std::int64_t> corners;
  for (std::size_t f = 0; f < faces; ++f) {
    corners.resize(file.count(NumberType::int64, 2, "corners"));
    for (std::int64_t& corner : corners) corner = file.integer();
    add_polygon(surface, corners, file);
    file.line();  // colours
  }
  return surface;
}

}  // namespace palpate::mesh_read
