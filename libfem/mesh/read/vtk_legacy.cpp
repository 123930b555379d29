// VTK legacy files, versions 1 to 5.1, ASCII and binary (always big endian).
#include <algorithm>
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

// Cell i has corners connectivity[end[i-1] .. end[i]), end[-1] = 0.
struct VtkCells {
  std::vector<std::int64_t> end;
  std::vector<std::int64_t> connectivity;
};

// Calls use(cell, corners) for each.
template <typename Use>
void for_each_cell(const VtkCells& cells, const Cursor& cursor, Use use) {
  std::int64_t begin = 0;
  for (std::size_t cell = 0; cell < cells.end.size(); ++cell) {
    const std::int64_t end = cells.end[cell];
    if (end < begin || end > static_cast<std::int64_t>(cells.connectivity.size()))
      cursor.fail("cell " + std::to_string(cell) + " has offsets outside the connectivity");
    use(cell, std::span(cells.connectivity).subspan(begin, end - begin));
    begin = end;
  }
}

void add_polygons(RawMesh& surface, const VtkCells& cells, const Cursor& cursor) {
  for_each_cell(cells, cursor, [&](std::size_t, std::span<const std::int64_t> corners) {
    add_polygon(surface, corners, cursor);
  });
}

// Every second triangle of a strip is turned.
void add_strips(RawMesh& surface, const VtkCells& cells, const Cursor& cursor) {
  for_each_cell(cells, cursor, [&](std::size_t, std::span<const std::int64_t> corners) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
      std::array<std::int64_t, 3> triangle{corners[i - 2], corners[i - 1], corners[i]};
      if (i % 2 == 1) std::swap(triangle[0], triangle[1]);
      add_polygon(surface, triangle, cursor);
    }
  });
}

// Adds the tets among cells of these VTK types, counts points, lines and faces as ignored.
void add_tets(RawMesh& mesh, const VtkCells& cells, const std::vector<std::int64_t>& types,
              const Cursor& cursor) {
  constexpr std::int64_t kTets[] = {10, 24, 71};  // the last two by their corners
  // Points, lines, triangles, quads and polygons, also quadratic and Lagrange.
  constexpr std::int64_t kFlat[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9, 21,
                                    22, 23, 28, 30, 34, 35, 36, 68, 69, 70};
  if (types.size() != cells.end.size())
    cursor.fail("there are " + std::to_string(cells.end.size()) + " cells but " +
                std::to_string(types.size()) + " cell types");
  for_each_cell(cells, cursor, [&](std::size_t cell, std::span<const std::int64_t> corners) {
    if (std::ranges::count(kFlat, types[cell]) > 0) {
      ++mesh.ignored_elements;
      return;
    }
    if (std::ranges::count(kTets, types[cell]) == 0)
      fail_not_tets(cursor, "VTK cell type " + std::to_string(types[cell]));
    if (corners.size() < 4) cursor.fail("a tetrahedron has fewer than 4 corners");
    add_tet(mesh, corners.first<4>(), static_cast<std::int64_t>(cell), cursor);
  });
}

NumberType read_type(Cursor& file) {
  const std::string_view name = file.word_on_line();
  if (const auto type = number_type(name)) return *type;
  file.fail(quoted(name) + " is not a number type of VTK");
}

// A legacy file: header read, then sections of which each begins with a line of text.
class LegacyFile {
 public:
  explicit LegacyFile(Cursor& file) : file_(file) {
    if (!file.line().starts_with("# vtk DataFile Version"))
      file.fail("does not begin with '# vtk DataFile Version'");
    file.line();  // title
    const std::string_view encoding = file.word();
    if (!same_word(encoding, "ASCII") && !same_word(encoding, "BINARY"))
      file.fail("the third line is neither ASCII nor BINARY");
    if (same_word(encoding, "BINARY")) data_ = Encoding::big_endian;
    file.expect("DATASET");
    dataset_ = file.word();
    file.line();
  }

  std::string_view dataset() const { return dataset_; }

  // The next section's keyword; empty at the end or where only attributes follow.
  std::string_view section() {
    while (!file_.at_end()) {
      const std::string_view keyword = file_.word_on_line();
      if (same_word(keyword, "CELL_DATA") || same_word(keyword, "POINT_DATA")) return {};
      if (same_word(keyword, "METADATA")) {
        skip_metadata();
      } else if (same_word(keyword, "FIELD")) {
        skip_field();
      } else {
        return keyword;
      }
    }
    return {};
  }

  std::vector<Vec3> points() {
    const std::int64_t number = file_.integer();
    const NumberType type = read_type(file_);
    file_.line();
    const std::size_t checked = file_.checked_count(number, 3 * min_bytes(type), "points");
    std::vector<Vec3> points(checked);
    file_.encoding = data_;
    for (Vec3& point : points) point = file_.position_3d(type);
    file_.encoding = Encoding::text;
    return points;
  }

  // "KEYWORD cells numbers" with count-prefixed cells, or offsets and connectivity (version 5).
  VtkCells cells() {
    const std::int64_t first = file_.integer(), second = file_.integer();
    file_.line();
    const std::size_t start = file_.position();
    if (second > 0 && same_word(file_.word(), "OFFSETS")) return offset_cells(first, second);
    file_.seek(start);
    return counted_cells(first, second);
  }

  std::vector<std::int64_t> cell_types() {
    const std::int64_t number = file_.integer();
    file_.line();
    return integers(number, NumberType::int32, "cell types");
  }

 private:
  std::size_t min_bytes(NumberType type) const {
    return data_ == Encoding::text ? 1 : size_of(type);
  }

  std::vector<std::int64_t> integers(std::int64_t number, NumberType type,
                                     std::string_view things) {
    std::vector<std::int64_t> values(file_.checked_count(number, min_bytes(type), things));
    file_.encoding = data_;
    for (std::int64_t& value : values) value = file_.integer(type);
    file_.encoding = Encoding::text;
    return values;
  }

  VtkCells offset_cells(std::int64_t offsets, std::int64_t corners) {
    VtkCells cells;
    const NumberType offset_type = read_type(file_);
    file_.line();
    cells.end = integers(offsets, offset_type, "offsets");
    if (cells.end.empty() || cells.end.front() != 0) file_.fail("cell offsets do not begin with 0");
    cells.end.erase(cells.end.begin());
    file_.expect("CONNECTIVITY");
    const NumberType corner_type = read_type(file_);
    file_.line();
    cells.connectivity = integers(corners, corner_type, "cell corners");
    return cells;
  }

  VtkCells counted_cells(std::int64_t number, std::int64_t numbers) {
    const std::vector<std::int64_t> list = integers(numbers, NumberType::int32, "cell entries");
    VtkCells cells;
    for (std::size_t at = 0; at < list.size();) {
      const std::int64_t corners = list[at++];
      if (corners < 0 || static_cast<std::uint64_t>(corners) > list.size() - at)
        file_.fail("a cell has more corners than its section");
      cells.connectivity.insert(cells.connectivity.end(), list.begin() + at,
                                list.begin() + at + corners);
      cells.end.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
      at += corners;
    }
    if (static_cast<std::int64_t>(cells.end.size()) != number)
      file_.fail("announces " + std::to_string(number) + " cells, holds " +
                 std::to_string(cells.end.size()));
    return cells;
  }

  void skip_metadata() {
    file_.line();
    while (file_.remaining() > 0 && !file_.line().empty()) {
    }  // ends with an empty line
  }

  // "FIELD name arrays" and its arrays.
  void skip_field() {
    file_.word_on_line();  // its name
    const std::int64_t arrays = file_.integer();
    for (std::int64_t a = 0; a < arrays; ++a) {
      file_.word();  // its name
      const std::size_t width = file_.count(NumberType::int64, 1, "components");
      const std::size_t rows = file_.count(NumberType::int64, 1, "rows");
      const NumberType type = read_type(file_);
      file_.line();
      if (width > 0 && rows > file_.remaining() / width)
        file_.fail("a field is larger than the file");
      file_.encoding = data_;
      for (std::size_t left = rows * width; left > 0; --left) file_.real(type);
      file_.encoding = Encoding::text;
    }
  }

  Cursor& file_;
  Encoding data_ = Encoding::text;
  std::string_view dataset_;
};

}  // namespace

RawMesh read_vtk_polydata(Cursor& file, RawLabels*) {
  LegacyFile legacy(file);
  if (!same_word(legacy.dataset(), "POLYDATA"))
    file.fail("holds a " + quoted(legacy.dataset()) + ", not POLYDATA",
              "Give a surface; tetrahedra (UNSTRUCTURED_GRID) are read as body.tetmesh.");
  RawMesh surface;
  for (auto keyword = legacy.section(); !keyword.empty(); keyword = legacy.section()) {
    if (same_word(keyword, "POINTS")) {
      surface.points = legacy.points();
    } else if (same_word(keyword, "POLYGONS")) {
      add_polygons(surface, legacy.cells(), file);
    } else if (same_word(keyword, "TRIANGLE_STRIPS")) {
      add_strips(surface, legacy.cells(), file);
    } else if (same_word(keyword, "VERTICES") || same_word(keyword, "LINES")) {
      legacy.cells();
    } else {
      file.fail(quoted(keyword) + " is not a section of POLYDATA");
    }
  }
  return surface;
}

RawMesh read_vtk_grid(Cursor& file, RawLabels*) {
  LegacyFile legacy(file);
  if (!same_word(legacy.dataset(), "UNSTRUCTURED_GRID"))
    file.fail("holds " + quoted(legacy.dataset()) + ", not an UNSTRUCTURED_GRID",
              "Give tetrahedra; a surface (POLYDATA) is read as body.surface.");
  RawMesh mesh;
  VtkCells cells;
  std::vector<std::int64_t> types;
  for (auto keyword = legacy.section(); !keyword.empty(); keyword = legacy.section()) {
    if (same_word(keyword, "POINTS")) {
      mesh.points = legacy.points();
    } else if (same_word(keyword, "CELLS")) {
      cells = legacy.cells();
    } else if (same_word(keyword, "CELL_TYPES")) {
      types = legacy.cell_types();
    } else {
      file.fail(quoted(keyword) + " is not a section of UNSTRUCTURED_GRID");
    }
  }
  add_tets(mesh, cells, types, file);
  return mesh;
}

}  // namespace palpate::mesh_read
