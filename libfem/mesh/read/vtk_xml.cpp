// VTP (surfaces) and VTU (tet meshes) of VTK, one or several pieces.
#include <zlib.h>
#include <algorithm>
#include <optional>
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

// Moves past `mark`, which must follow.
void skip_past(Cursor& file, std::string_view mark) {
  const std::size_t at = file.bytes().find(mark, file.position());
  if (at == std::string_view::npos) file.fail("a tag is not closed");
  file.seek(at + mark.size());
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

// <name attributes> or </name>.
struct XmlTag {
  std::string_view name;
  std::string_view attributes;
  bool is_end = false;     ///< </name>
  bool is_closed = false;  ///< <name/>
  std::size_t after = 0;   ///< byte after the tag
};

// The next tag from the cursor's position, which moves past it; none when there is no more.
// Passes over text, comments and processing instructions. Safe on untrusted bytes. This is all of
// XML that VTK needs; its appended raw bytes are no XML, so a general parser would refuse them.
std::optional<XmlTag> next_tag(Cursor& file) {
  const std::string_view bytes = file.bytes();
  while (true) {
    const std::size_t open = bytes.find('<', file.position());
    if (open == std::string_view::npos) return std::nullopt;
    file.seek(open);
    if (bytes.substr(open, 4) == "<!--") {
      skip_past(file, "-->");
      continue;
    }
    skip_past(file, ">");
    std::string_view inside = bytes.substr(open + 1, file.position() - open - 2);
    if (inside.starts_with('?') || inside.starts_with('!')) continue;
    XmlTag tag;
    tag.after = file.position();
    tag.is_end = inside.starts_with('/');
    if (tag.is_end) inside.remove_prefix(1);
    tag.is_closed = inside.ends_with('/');
    if (tag.is_closed) inside.remove_suffix(1);
    tag.name = inside.substr(0, inside.find_first_of(kBlanks));
    tag.attributes = inside.substr(tag.name.size());
    file.seek(open);  // so that failures name the tag
    return tag;
  }
}

std::string_view attribute(const XmlTag& tag, std::string_view name) {
  std::string_view rest = tag.attributes;
  while (true) {
    const std::size_t equals = rest.find('=');
    if (equals == std::string_view::npos) return {};
    const std::string_view found = trimmed(rest.substr(0, equals));
    rest = trimmed(rest.substr(equals + 1));
    if (rest.empty() || (rest[0] != '"' && rest[0] != '\'')) return {};
    const std::size_t end = rest.find(rest[0], 1);
    if (end == std::string_view::npos) return {};
    if (found == name) return rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
  }
}

// A <DataArray> of a VTK XML file: where its numbers are and how they are written.
struct VtkArray {
  std::string section;  ///< the element around it: Points, Polys, Cells, ...
  std::string name;
  NumberType type = NumberType::float64;
  std::string format;        ///< ascii, binary (inline base64) or appended
  std::size_t content = 0;   ///< byte after the tag
  std::int64_t offset = -1;  ///< into the appended data
};

// A <Piece>: its counts (0 where absent) and arrays.
struct VtkPiece {
  std::int64_t points = 0, cells = 0, verts = 0, lines = 0, polys = 0, strips = 0;
  std::vector<VtkArray> arrays;
};

std::int64_t count_attribute(const XmlTag& tag, std::string_view name, const Cursor& file) {
  const std::string_view text = attribute(tag, name);
  if (text.empty()) return 0;
  const auto number = parse_integer(text);
  if (!number || *number < 0 || *number > INT32_MAX)
    file.fail(std::string(name) + " is not a count below 2^31");
  return *number;
}

VtkArray read_array_tag(const XmlTag& tag, std::string section, const Cursor& file) {
  VtkArray array;
  array.section = std::move(section);
  array.name = attribute(tag, "Name");
  array.format = attribute(tag, "format");
  array.content = tag.after;
  const auto type = attribute(tag, "type") == "String" ? NumberType::int8  // codes of characters
                                                       : number_type(attribute(tag, "type"));
  if (!type) file.fail("array '" + array.name + "' is of no number type of VTK");
  array.type = *type;
  if (array.format == "appended") {
    const auto offset = parse_integer(attribute(tag, "offset"));
    if (!offset || *offset < 0) file.fail("array '" + array.name + "' has no offset");
    array.offset = *offset;
  } else if (array.format != "ascii" && array.format != "binary") {
    file.fail("array '" + array.name + "' has an unknown format");
  }
  return array;
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

// Decodes up to the first character that is neither base64 nor blank. Padding ends a group, not the
// text: VTK encodes a compressed block's header apart from its data.
std::string decode_base64(std::string_view text) {
  std::string out;
  out.reserve(text.size() / 4 * 3);
  unsigned bits = 0;
  int held = 0, padding = 0;
  for (const char c : text) {
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
    if (c == '=')
      ++padding;
    else if (base64_value(c) < 0)
      break;
    bits = bits << 6 | static_cast<unsigned>(std::max(base64_value(c), 0));
    if (++held < 4) continue;
    for (int byte = 0; byte < 3 - padding; ++byte)
      out += static_cast<char>(bits >> (16 - 8 * byte) & 0xFF);
    bits = 0;
    held = padding = 0;
  }
  return out;
}

// A VTK XML file of one data set type, its tags read, its arrays read on demand.
// ASCII, inline base64, appended raw and appended base64; zlib-compressed or not; 32 and 64 bit
// headers; both byte orders. Safe on untrusted bytes.
class VtkXmlFile {
 public:
  // type: PolyData or UnstructuredGrid. Throws Error when the file is of another type, or written
  // with a compressor other than zlib.
  VtkXmlFile(Cursor& file, std::string_view type) : file_(file) {
    std::vector<std::string> open;  // sections around the present tag
    bool is_vtk = false, is_inside_piece = false;
    while (const auto tag = next_tag(file)) {
      if (tag->name == "VTKFile" && !tag->is_end) {
        is_vtk = true;
        if (attribute(*tag, "type") != type)
          file.fail("holds " + quoted(attribute(*tag, "type")) + ", not " + std::string(type),
                    type == "PolyData" ? "Give a surface; a volume mesh is read as body.tetmesh."
                                       : "Give tetrahedra; a surface is read as body.surface.");
        if (attribute(*tag, "byte_order") == "BigEndian") byte_order_ = Encoding::big_endian;
        if (attribute(*tag, "header_type") == "UInt64") header_ = NumberType::uint64;
        const std::string_view compressor = attribute(*tag, "compressor");
        is_compressed_ = !compressor.empty();
        if (is_compressed_ && compressor != "vtkZLibDataCompressor")
          file.fail("is compressed with " + quoted(compressor),
                    "Save the file without compression or with zlib.");
      } else if (tag->name == "AppendedData" && !tag->is_end) {
        is_appended_base64_ = attribute(*tag, "encoding") == "base64";
        const std::size_t mark = file.bytes().find('_', tag->after);
        if (mark == std::string_view::npos) file.fail("the appended data lacks its underscore");
        appended_ = mark + 1;
        break;
      } else if (tag->name == "Piece") {
        is_inside_piece = !tag->is_end && !tag->is_closed;
        if (is_inside_piece)
          pieces_.push_back({count_attribute(*tag, "NumberOfPoints", file),
                             count_attribute(*tag, "NumberOfCells", file),
                             count_attribute(*tag, "NumberOfVerts", file),
                             count_attribute(*tag, "NumberOfLines", file),
                             count_attribute(*tag, "NumberOfPolys", file),
                             count_attribute(*tag, "NumberOfStrips", file),
                             {}});
      } else if (is_inside_piece && tag->name == "DataArray") {
        const bool is_geometry =
            !open.empty() && open.back() != "PointData" && open.back() != "CellData";
        const bool is_number = number_type(attribute(*tag, "type")).has_value();
        if (!tag->is_end && !open.empty() && (is_geometry || is_number))
          pieces_.back().arrays.push_back(read_array_tag(*tag, open.back(), file));
      } else if (!is_inside_piece && tag->name == "Array" && attribute(*tag, "type") == "String") {
        fields_.arrays.push_back(read_array_tag(*tag, "FieldData", file));
      } else if (is_inside_piece && !tag->is_closed) {
        if (!tag->is_end)
          open.emplace_back(tag->name);
        else if (!open.empty())
          open.pop_back();
      }
      file.seek(tag->after);
    }
    if (!is_vtk) file.fail("has no <VTKFile> tag");
  }

  const std::vector<VtkPiece>& pieces() const { return pieces_; }

  // The numbers of the array `name` in `section` of a piece (empty name: the section's first).
  // Throws when there is none, or it has not exactly `number` values (any number if negative).
  std::vector<double> reals(const VtkPiece& piece, std::string_view section, std::string_view name,
                            std::int64_t number) const {
    const VtkArray& array = find(piece, section, name);
    std::vector<double> values;
    if (array.format == "ascii") {
      Cursor text(file_.bytes().substr(0, file_.bytes().find('<', array.content)), file_.file());
      text.seek(array.content);
      while (!text.at_end()) values.push_back(text.real());
    } else {
      const std::string bytes = bytes_of(array);
      const std::size_t size = size_of(array.type);
      for (std::size_t at = 0; at + size <= bytes.size(); at += size)
        values.push_back(decode_real(bytes.data() + at, array.type, byte_order_));
    }
    if (number >= 0 && values.size() != static_cast<std::size_t>(number))
      file_.fail_at(array.content, "array '" + array.name + "' of <" + array.section + "> has " +
                                       std::to_string(values.size()) + " numbers instead of " +
                                       std::to_string(number));
    return values;
  }

  std::vector<std::int64_t> integers(const VtkPiece& piece, std::string_view section,
                                     std::string_view name, std::int64_t number) const {
    const std::vector<double> values = reals(piece, section, name, number);
    std::vector<std::int64_t> integers(values.size());
    // Indices are below 2^31, so a double holds them; what is no index becomes -1, refused later.
    std::ranges::transform(values, integers.begin(), [](double value) {
      return value >= 0 && value < 0x1p53 ? static_cast<std::int64_t>(value) : std::int64_t{-1};
    });
    return integers;
  }

  // The first text of the array of texts `name` in the file's field data; empty where it has none.
  std::string field_text(std::string_view name) const {
    for (const VtkArray& array : fields_.arrays) {
      if (array.name != name) continue;
      std::string text;
      for (const double code : reals(fields_, array.section, name, -1)) {
        if (code == 0) break;
        text += static_cast<char>(code);
      }
      return text;
    }
    return {};
  }

 private:
  const VtkArray& find(const VtkPiece& piece, std::string_view section,
                       std::string_view name) const {
    for (const VtkArray& array : piece.arrays)
      if (array.section == section && (name.empty() || array.name == name)) return array;
    file_.fail("a piece lacks the array <" + std::string(section) + "> " + std::string(name));
  }

  std::string bytes_of(const VtkArray& array) const {
    const std::string_view all = file_.bytes();
    if (array.format == "binary") {
      const std::string_view text = all.substr(array.content);
      return unpack(decode_base64(text.substr(0, text.find('<'))), array.content);
    }
    if (appended_ == 0 || static_cast<std::uint64_t>(array.offset) > all.size() - appended_)
      file_.fail_at(array.content, "array '" + array.name + "' lies past the appended data");
    const std::size_t start = appended_ + array.offset;
    const std::string_view block = all.substr(start);
    return is_appended_base64_ ? unpack(decode_base64(block), start) : unpack(block, start);
  }

  // The bytes of an array from its block: a header that counts them, then they, or zlib blocks.
  std::string unpack(std::string_view block, std::size_t position) const {
    if (is_compressed_) return inflate(block, position);
    const std::size_t header = size_of(header_);
    if (block.size() < header) file_.fail_at(position, "an array's header is cut short");
    const std::int64_t bytes = decode_integer(block.data(), header_, byte_order_);
    if (bytes < 0 || static_cast<std::uint64_t>(bytes) > block.size() - header)
      file_.fail_at(position, "an array is longer than the file");
    return std::string(block.substr(header, bytes));
  }

  std::string inflate(std::string_view block, std::size_t position) const {
    Cursor in(block, file_.file());
    in.encoding = byte_order_;
    const auto damaged = [&]() { file_.fail_at(position, "a compressed array is damaged"); };
    if (block.size() < 3 * size_of(header_)) damaged();
    const std::int64_t blocks = in.integer(header_);
    const std::int64_t block_bytes = in.integer(header_), last = in.integer(header_);
    if (blocks < 0 || block_bytes < 0 || last < 0 || last > std::int64_t{1} << 32 ||
        block_bytes > std::int64_t{1} << 32 ||
        static_cast<std::uint64_t>(blocks) > in.remaining() / size_of(header_))
      damaged();
    std::vector<std::size_t> packed(blocks);
    for (std::size_t& size : packed) size = in.integer(header_);

    std::string out;
    for (std::size_t b = 0; b < packed.size(); ++b) {
      const bool is_partial = b + 1 == packed.size() && last > 0;
      const auto size = static_cast<std::size_t>(is_partial ? last : block_bytes);
      // zlib shrinks no further than to a 1032nd (its manual, "maximum compression factor"), so a
      // header that promises more is damaged: checked before memory is taken.
      if (packed[b] > in.remaining() || size / 1032 > packed[b]) damaged();
      const std::size_t before = out.size();
      out.resize(before + size);
      uLongf written = static_cast<uLongf>(size);
      const int status = uncompress(reinterpret_cast<Bytef*>(out.data() + before), &written,
                                    reinterpret_cast<const Bytef*>(block.data() + in.position()),
                                    static_cast<uLong>(packed[b]));
      if (status != Z_OK || written != size) damaged();
      in.take(packed[b]);
    }
    return out;
  }

  Cursor& file_;
  std::vector<VtkPiece> pieces_;
  VtkPiece fields_;  // arrays of texts in <FieldData>
  Encoding byte_order_ = Encoding::little_endian;
  NumberType header_ = NumberType::uint32;
  bool is_compressed_ = false;
  bool is_appended_base64_ = false;
  std::size_t appended_ = 0;  // byte after the underscore
};

void append_points(const VtkXmlFile& xml, const VtkPiece& piece, const Cursor& file,
                   std::vector<Vec3>& points) {
  if (piece.points == 0) return;
  const std::vector<double> xyz = xml.reals(piece, "Points", "", 3 * piece.points);
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    Vec3& point = points.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
      point[k] = file.coordinate(xyz[i + k], " in point " + std::to_string(i / 3));
  }
}

VtkCells read_cells(const VtkXmlFile& xml, const VtkPiece& piece, const char* section,
                    std::int64_t number) {
  if (number == 0) return {};
  return {xml.integers(piece, section, "offsets", number),
          xml.integers(piece, section, "connectivity", -1)};
}

// Values on points and cells of a piece, behind those of the pieces before it.
void append_fields(const VtkXmlFile& xml, const VtkPiece& piece, RawLabels& labels) {
  for (const VtkArray& array : piece.arrays) {
    const bool is_on_points = array.section == "PointData";
    if (!is_on_points && array.section != "CellData") continue;
    std::vector<double>& all = labels.field(array.name, is_on_points).values;
    const std::vector<double> here = xml.reals(piece, array.section, array.name, -1);
    all.insert(all.end(), here.begin(), here.end());
  }
}

}  // namespace

std::string vtk_field_text(Cursor& file, std::string_view type, std::string_view name) {
  return VtkXmlFile(file, type).field_text(name);
}

RawMesh read_vtp(Cursor& file, RawLabels* labels) {
  const VtkXmlFile xml(file, "PolyData");
  RawMesh surface;
  for (const VtkPiece& piece : xml.pieces()) {
    const std::size_t base = surface.points.size();
    append_points(xml, piece, file, surface.points);
    const VtkCells polygons = read_cells(xml, piece, "Polys", piece.polys),
                   strips = read_cells(xml, piece, "Strips", piece.strips);
    add_polygons(surface, polygons, base, file);
    add_strips(surface, strips, base, file);
    if (labels == nullptr) continue;
    labels->cells += static_cast<std::int32_t>(piece.verts + piece.lines);
    note_cells(polygons, *labels);
    note_cells(strips, *labels);
    append_fields(xml, piece, *labels);
  }
  return surface;
}

RawMesh read_vtu(Cursor& file, RawLabels* labels) {
  const VtkXmlFile xml(file, "UnstructuredGrid");
  RawMesh mesh;
  for (const VtkPiece& piece : xml.pieces()) {
    const std::size_t base = mesh.points.size();
    append_points(xml, piece, file, mesh.points);
    if (piece.cells == 0) continue;
    add_tets(mesh, read_cells(xml, piece, "Cells", piece.cells),
             xml.integers(piece, "Cells", "types", piece.cells), base, file, labels);
    if (labels != nullptr) append_fields(xml, piece, *labels);
  }
  return mesh;
}

}  // namespace palpate::mesh_read
