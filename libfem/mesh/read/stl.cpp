// STL, ASCII and binary. The format repeats every corner: corners identical to the bit are one
// vertex.
#include <string>
#include <unordered_map>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfit/core/text.hpp"

namespace palpate::mesh_read {
namespace {

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
