// Wavefront OBJ: `v` and `f` lines, and `g`, `o` and `usemtl` where groups are asked for; texture
// and normal lines are passed over.

#include <string>
#include <unordered_map>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

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
    labels.cell.insert(labels.cell.end(), triangles, labels.cells++);
  }
};

// Object File Format of Geomview: OFF and its variants with normals, colours and texture
// coordinates (COFF, NOFF, STOFF, CNOFF, ...), a vertex or face per line, # comments.

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

// STL, ASCII and binary. The format repeats every corner: corners identical to the bit are one
// vertex.

constexpr std::size_t kHeader = 84,
                      kFacet = 50;  // bytes: text and count; normal, corners, attribute

struct HashPoint {
  std::size_t operator()(const std::array<double, 3>& p) const {
    return hash_of({reinterpret_cast<const char*>(p.data()), sizeof p});
  }
};

class Merger {
 public:
  explicit Merger(RawMesh& surface) : surface_(surface) {}

  std::int32_t index_of(Vec3 point) {
    point.array() += 0.0;  // -0 becomes +0: the same place
    const auto [at, is_new] = index_.try_emplace({point.x(), point.y(), point.z()},
                                                 static_cast<std::int32_t>(surface_.points.size()));
    if (is_new) surface_.points.push_back(point);
    return at->second;
  }

 private:
  RawMesh& surface_;
  std::unordered_map<std::array<double, 3>, std::int32_t, HashPoint> index_;
};

RawMesh read_binary(Cursor& file, std::size_t facets) {
  RawMesh surface;
  Merger merger(surface);
  surface.triangles.reserve(facets);
  for (std::size_t f = 0; f < facets; ++f) {
    file.take(12);
    std::array<std::int32_t, 3> triangle;
    for (std::int32_t& corner : triangle)
      corner = merger.index_of(file.position_3d(NumberType::float32));
    file.take(2);
    surface.triangles.push_back(triangle);
  }
  return surface;
}

RawMesh read_text(Cursor& file) {
  RawMesh surface;
  Merger merger(surface);
  while (!file.at_end()) {
    file.expect("solid");
    file.line();
    for (std::string_view word = file.word(); !same_word(word, "endsolid"); word = file.word()) {
      if (!same_word(word, "facet")) file.fail("expected 'facet' or 'endsolid'");
      file.line();  // the normal follows from the corners
      file.expect("outer");
      file.expect("loop");
      std::array<std::int32_t, 3> triangle;
      for (std::int32_t& corner : triangle) {
        file.expect("vertex");
        corner = merger.index_of(file.position_3d());
      }
      file.expect("endloop");
      file.expect("endfacet");
      surface.triangles.push_back(triangle);
    }
    file.line();
  }
  return surface;
}

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

RawMesh read_stl(Cursor& file, RawLabels*) {
  const std::string_view bytes = file.bytes();
  // Binary files may begin with "solid" too, so the exact size decides.
  if (bytes.size() >= kHeader) {
    const auto facets = static_cast<std::size_t>(
        decode_integer(bytes.data() + 80, NumberType::uint32, Encoding::little_endian));
    const bool is_exact = bytes.size() == kHeader + kFacet * facets;
    if (is_exact || !same_word(bytes.substr(0, 5), "solid")) {
      file.encoding = Encoding::little_endian;
      file.seek(80);
      file.take(4);
      if (!is_exact)
        file.fail("a binary STL of " + std::to_string(facets) + " facets has " +
                      std::to_string(kHeader + kFacet * facets) + " bytes, this file has " +
                      std::to_string(bytes.size()),
                  "The file is cut short or damaged; copy or export it again.");
      return read_binary(file, facets);
    }
  }
  return read_text(file);
}

}  // namespace palpate::mesh_read
