// Stanford PLY: ASCII, binary little and big endian; besides the vertices' x y z
// and the faces' vertex_indices nothing is taken.
#include <algorithm>
#include <optional>
#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

struct Property {
  std::string name;
  NumberType type;
  std::optional<NumberType> count_type;  // of a list
};

struct Element {
  std::string name;
  std::int64_t number;
  std::vector<Property> properties;
};

struct PlyHeader {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
};

NumberType read_type(Cursor& file) {
  if (const auto type = number_type(file.word())) return *type;
  file.fail("not a number type of PLY");
}

Encoding read_encoding(Cursor& file) {
  const std::string_view word = file.word();
  if (word == "ascii") return Encoding::text;
  if (word == "binary_little_endian") return Encoding::little_endian;
  if (word == "binary_big_endian") return Encoding::big_endian;
  file.fail("not a PLY encoding (ascii, binary_little_endian, binary_big_endian)");
}

Property read_property(Cursor& file) {
  const std::size_t start = file.position();
  std::optional<NumberType> count_type;
  if (file.word() == "list") {
    count_type = read_type(file);
  } else {
    file.seek(start);
  }
  const NumberType type = read_type(file);
  return {std::string(file.word()), type, count_type};
}

PlyHeader read_header(Cursor& file) {
  PlyHeader header;
  file.expect("ply");
  for (std::string_view keyword = file.word(); keyword != "end_header"; keyword = file.word()) {
    if (keyword == "format") {
      header.encoding = read_encoding(file);
    } else if (keyword == "element") {
      std::string name(file.word());
      header.elements.push_back({std::move(name), file.integer(), {}});
    } else if (keyword == "property") {
      if (header.elements.empty()) file.fail("a property comes before any element");
      header.elements.back().properties.push_back(read_property(file));
    } else if (keyword != "comment" && keyword != "obj_info") {
      file.fail("not a keyword of a PLY header");
    }
    file.line();
  }
  file.line();
  return header;
}

// Fewest bytes an element can take; a number as text takes a digit and a blank.
std::size_t min_bytes(const Element& element, Encoding encoding) {
  std::size_t sum = 0;
  for (const Property& p : element.properties)
    sum += encoding == Encoding::text ? 2 : size_of(p.count_type.value_or(p.type));
  // The last number of a text file may lack the blank.
  return encoding == Encoding::text ? sum - 1 : sum;
}

std::size_t find_property(const Element& element, std::initializer_list<std::string_view> names,
                          bool is_list, const Cursor& file) {
  for (std::size_t i = 0; i < element.properties.size(); ++i)
    for (const std::string_view name : names)
      if (element.properties[i].name == name &&
          element.properties[i].count_type.has_value() == is_list)
        return i;
  file.fail("element '" + element.name + "' has no property '" + std::string(*names.begin()) + "'");
}

// Numbers of a property: those that its list announces, or one.
std::size_t numbers_of(Cursor& file, const Property& p) {
  const std::size_t least = file.encoding == Encoding::text ? 1 : size_of(p.type);
  return p.count_type ? file.count(*p.count_type, least, "list entries") : 1;
}

void skip_property(Cursor& file, const Property& p) {
  for (std::size_t left = numbers_of(file, p); left > 0; --left) file.real(p.type);
}

void read_vertices(Cursor& file, const Element& element, std::size_t number, RawMesh& surface) {
  const std::array<std::size_t, 3> axis{find_property(element, {"x"}, false, file),
                                        find_property(element, {"y"}, false, file),
                                        find_property(element, {"z"}, false, file)};
  surface.points.reserve(number);
  for (std::size_t v = 0; v < number; ++v) {
    Vec3 point;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& p = element.properties[i];
      const auto which = std::find(axis.begin(), axis.end(), i);
      if (which == axis.end()) {
        skip_property(file, p);
        continue;
      }
      point[which - axis.begin()] = file.coordinate(file.real(p.type));
    }
    surface.points.push_back(point);
  }
}

void read_faces(Cursor& file, const Element& element, std::size_t number, RawMesh& surface) {
  const std::size_t corners_at =
      find_property(element, {"vertex_indices", "vertex_index"}, true, file);
  std::vector<std::int64_t> corners;
  for (std::size_t f = 0; f < number; ++f) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& p = element.properties[i];
      if (i != corners_at) {
        skip_property(file, p);
        continue;
      }
      corners.resize(numbers_of(file, p));
      for (std::int64_t& corner : corners) corner = file.integer(p.type);
      add_polygon(surface, corners, file);
    }
  }
}

}  // namespace

RawMesh read_ply(Cursor& file, RawLabels*) {
  const PlyHeader header = read_header(file);
  file.encoding = header.encoding;
  RawMesh surface;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;  // takes no bytes, however many there are
    const std::size_t number =
        file.checked_count(element.number, min_bytes(element, header.encoding), element.name);
    if (element.name == "vertex") {
      read_vertices(file, element, number, surface);
    } else if (element.name == "face") {
      read_faces(file, element, number, surface);
    } else if (element.name == "tristrips") {
      file.fail("triangle strips are not supported", "Export the PLY with plain faces.");
    } else {
      for (std::size_t e = 0; e < number; ++e)
        for (const Property& p : element.properties) skip_property(file, p);
    }
  }
  return surface;
}

}  // namespace palpate::mesh_read
