// Wavefront OBJ: `v` and `f` lines, and `g`, `o` and `usemtl` where groups are asked for; texture
// and normal lines are passed over.
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

// The largest vertex number a face used, and where: faces may come before their vertices.
struct Furthest {
  std::int64_t index = -1;
  std::size_t position = 0;
};

// The next word of a statement, which a backslash at the end of a line continues in the next one.
std::string_view word_of_statement(Cursor& file) {
  std::string_view word = file.word_on_line();
  while (word == "\\") {
    file.line();
    word = file.word_on_line();
  }
  if (!word.ends_with('\\')) return word;
  file.seek(file.position() - 1);
  return word.substr(0, word.size() - 1);
}

// "7", "7/1", "7//3", "7/1/3" or negative (counted back from the latest vertex), as index from 0.
std::int64_t corner_index(std::string_view word, std::size_t points, const Cursor& file) {
  const auto number = parse_integer(word.substr(0, word.find('/')));
  if (!number || *number == 0)
    file.fail("a face corner is not a vertex number (from 1, or negative)");
  const std::int64_t index =
      *number > 0 ? *number - 1 : static_cast<std::int64_t>(points) + *number;
  if (index < 0) file.fail("a face counts back past the first vertex");
  if (index > INT32_MAX) file.fail("a face uses a vertex number above 2^31 - 1");
  return index;
}

void read_vertex(Cursor& file, RawMesh& surface) {
  Vec3 point;
  for (double& x : point) {
    const auto value = parse_real(word_of_statement(file));
    if (!value) file.fail("a vertex needs three numbers, with decimal points");
    x = file.coordinate(*value);
  }
  surface.points.push_back(point);
}

void read_face(Cursor& file, RawMesh& surface, Furthest& furthest) {
  std::vector<std::int64_t> corners;
  for (std::string_view word = word_of_statement(file); !word.empty();
       word = word_of_statement(file)) {
    corners.push_back(corner_index(word, surface.points.size(), file));
    if (corners.back() > furthest.index) furthest = {corners.back(), file.position()};
  }
  if (corners.size() < 3) file.fail("a face has fewer than 3 corners");
  for (std::size_t i = 2; i < corners.size(); ++i)
    surface.triangles.push_back({static_cast<std::int32_t>(corners[0]),
                                 static_cast<std::int32_t>(corners[i - 1]),
                                 static_cast<std::int32_t>(corners[i])});
}

// Groups that the next faces belong to: those of `g`, and one each of `o` and `usemtl`.
struct FaceGroups {
  std::vector<std::string> g, object, material;

  void note(Cursor& file, std::string_view keyword) {
    auto& names = keyword == "g" ? g : keyword == "o" ? object : material;
    names.clear();
    for (std::string_view word = word_of_statement(file); !word.empty();
         word = word_of_statement(file))
      names.emplace_back(word);
  }
  void add_face(std::size_t triangles, RawLabels& labels) const {
    for (const auto* names : {&g, &object, &material})
      for (const std::string& name : *names) {
        auto& cells = labels.group(name, 2).cells;
        if (cells.empty() || cells.back() != labels.cells) cells.push_back(labels.cells);
      }
    labels.add_cell(triangles);
  }
};

}  // namespace

RawMesh read_obj(Cursor& file, RawLabels* labels) {
  file.comment = '#';
  RawMesh surface;
  Furthest furthest;
  FaceGroups groups;
  while (!file.at_end()) {
    const std::string_view keyword = word_of_statement(file);
    if (keyword == "v") read_vertex(file, surface);
    if (labels != nullptr && (keyword == "g" || keyword == "o" || keyword == "usemtl"))
      groups.note(file, keyword);
    if (keyword == "f") {
      const std::size_t before = surface.triangles.size();
      read_face(file, surface, furthest);
      if (labels != nullptr) groups.add_face(surface.triangles.size() - before, *labels);
    }
    file.line();
  }
  if (furthest.index >= static_cast<std::int64_t>(surface.points.size()))
    file.fail_at(furthest.position - 1, "a face uses vertex " + std::to_string(furthest.index + 1) +
                                            ", but there are " +
                                            std::to_string(surface.points.size()));
  return surface;
}

}  // namespace palpate::mesh_read
