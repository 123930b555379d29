// VTK legacy files, versions 1 to 5.1, ASCII and binary (always big endian).
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

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
      const std::size_t start = file_.position();
      const std::string_view keyword = file_.word_on_line();
      if (same_word(keyword, "CELL_DATA") || same_word(keyword, "POINT_DATA")) {
        file_.seek(start);
        return {};
      }
      if (same_word(keyword, "METADATA")) {
        skip_metadata();
      } else if (same_word(keyword, "FIELD")) {
        read_field({}, nullptr);
      } else {
        return keyword;
      }
    }
    return {};
  }

  // Values on cells and points, behind the geometry.
  void attributes(RawLabels& labels) {
    bool is_on_points = false;
    std::size_t rows = 0;
    while (!file_.at_end()) {
      const std::string_view keyword = file_.word_on_line();
      const auto is = [&](std::string_view word) { return same_word(keyword, word); };
      if (is("CELL_DATA") || is("POINT_DATA")) {
        is_on_points = is("POINT_DATA");
        rows = file_.count(NumberType::int64, 0, "rows");
        file_.line();
      } else if (is("METADATA")) {
        skip_metadata();
      } else if (is("FIELD")) {
        read_field(is_on_points, &labels);
      } else if (is("LOOKUP_TABLE")) {
        file_.word_on_line();
        const std::size_t colours = file_.count(NumberType::int64, 4, "colours");
        file_.line();
        values(colours, 4, data_ == Encoding::text ? NumberType::float64 : NumberType::uint8);
      } else {
        read_attribute(keyword, rows, labels.field(file_.word_on_line(), is_on_points));
      }
    }
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

  std::vector<double> values(std::size_t rows, std::size_t width, NumberType type) {
    if (width > 0 && rows > file_.remaining() / width)
      file_.fail("a field is larger than the file");
    std::vector<double> out(rows * width);
    file_.encoding = data_;
    for (double& value : out) value = file_.real(type);
    file_.encoding = Encoding::text;
    return out;
  }

  // "KEYWORD name ..." behind its name.
  void read_attribute(std::string_view keyword, std::size_t rows, RawLabels::Field& field) {
    struct Attribute {
      std::string_view name;
      std::size_t width;
    };
    constexpr Attribute kAttributes[] = {{"SCALARS", 1},     {"VECTORS", 3},  {"NORMALS", 3},
                                         {"TENSORS", 9},     {"TENSORS6", 6}, {"GLOBAL_IDS", 1},
                                         {"PEDIGREE_IDS", 1}};
    std::size_t width = 0;
    NumberType type = NumberType::float32;
    const auto small_count = [&](std::string_view word) {
      const auto number = parse_integer(word);
      if (!number || *number < 1 || *number > 9) file_.fail("a field has 1 to 9 components");
      return static_cast<std::size_t>(*number);
    };
    if (same_word(keyword, "TEXTURE_COORDINATES")) {
      width = small_count(file_.word_on_line());
      type = read_type(file_);
    } else if (same_word(keyword, "COLOR_SCALARS")) {
      width = small_count(file_.word_on_line());
      type = data_ == Encoding::text ? NumberType::float64 : NumberType::uint8;
    } else {
      for (const Attribute& row : kAttributes)
        if (same_word(keyword, row.name)) width = row.width;
      if (width == 0) file_.fail(quoted(keyword) + " is no attribute of VTK");
      type = read_type(file_);
      if (const std::string_view more = file_.word_on_line(); !more.empty())
        width = small_count(more);
    }
    file_.line();
    if (same_word(keyword, "SCALARS")) {
      const std::size_t start = file_.position();
      if (same_word(file_.word(), "LOOKUP_TABLE"))
        file_.line();
      else
        file_.seek(start);
    }
    field.values = values(rows, width, type);
  }

  // "FIELD name arrays" and its arrays; labels: null to pass over them.
  void read_field(bool is_on_points, RawLabels* labels) {
    file_.word_on_line();  // its name
    const std::int64_t arrays = file_.integer();
    for (std::int64_t a = 0; a < arrays; ++a) {
      const std::string_view name = file_.word();
      const std::size_t width = file_.count(NumberType::int64, 1, "components");
      const std::size_t rows = file_.count(NumberType::int64, 1, "rows");
      const NumberType type = read_type(file_);
      file_.line();
      std::vector<double> read = values(rows, width, type);
      if (labels != nullptr) labels->field(name, is_on_points).values = std::move(read);
    }
  }

  Cursor& file_;
  Encoding data_ = Encoding::text;
  std::string_view dataset_;
};

}  // namespace

RawMesh read_vtk_polydata(Cursor& file, RawLabels* labels) {
  LegacyFile legacy(file);
  if (!same_word(legacy.dataset(), "POLYDATA"))
    file.fail("holds a " + quoted(legacy.dataset()) + ", not POLYDATA",
              "Give a surface; tetrahedra (UNSTRUCTURED_GRID) are read as body.tetmesh.");
  RawMesh surface;
  // VTK counts cells in this order, whatever that of the sections.
  VtkCells vertices, lines, polygons, strips;
  for (auto keyword = legacy.section(); !keyword.empty(); keyword = legacy.section()) {
    if (same_word(keyword, "POINTS")) {
      surface.points = legacy.points();
    } else if (same_word(keyword, "POLYGONS")) {
      add_polygons(surface, polygons = legacy.cells(), 0, file);
    } else if (same_word(keyword, "TRIANGLE_STRIPS")) {
      add_strips(surface, strips = legacy.cells(), 0, file);
    } else if (same_word(keyword, "VERTICES")) {
      vertices = legacy.cells();
    } else if (same_word(keyword, "LINES")) {
      lines = legacy.cells();
    } else {
      file.fail(quoted(keyword) + " is not a section of POLYDATA");
    }
  }
  if (labels != nullptr) {
    labels->cells = static_cast<std::int32_t>(vertices.end.size() + lines.end.size());
    note_cells(polygons, *labels);
    note_cells(strips, *labels);
    legacy.attributes(*labels);
  }
  return surface;
}

RawMesh read_vtk_grid(Cursor& file, RawLabels* labels) {
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
  add_tets(mesh, cells, types, 0, file, labels);
  if (labels != nullptr) legacy.attributes(*labels);
  return mesh;
}

}  // namespace palpate::mesh_read
