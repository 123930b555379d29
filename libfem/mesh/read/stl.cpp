// STL, ASCII and binary. The format repeats every corner: corners identical to the bit are one
// vertex.
#include <cstring>
#include <string>
#include <unordered_map>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

constexpr std::size_t kHeader = 84,
                      kFacet = 50;  // bytes: text and count; normal, corners, attribute

struct PointBits {
  std::array<std::uint64_t, 3> bits;
  bool operator==(const PointBits&) const = default;
};
struct HashBits {
  std::size_t operator()(const PointBits& p) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t b : p.bits) hash = (hash ^ b ^ (b >> 29)) * 0x9E3779B97F4A7C15u;
    return hash ^ (hash >> 32);
  }
};

class Merger {
 public:
  explicit Merger(RawSurface& surface) : surface_(surface) {}

  std::int32_t index_of(Vec3 point) {
    point.array() += 0.0;  // -0 becomes +0: the same place
    PointBits key;
    std::memcpy(key.bits.data(), point.data(), sizeof key.bits);
    const auto [at, is_new] =
        index_.try_emplace(key, static_cast<std::int32_t>(surface_.points.size()));
    if (is_new) surface_.points.push_back(point);
    return at->second;
  }

 private:
  RawSurface& surface_;
  std::unordered_map<PointBits, std::int32_t, HashBits> index_;
};

RawSurface read_binary(Cursor& file, std::size_t facets) {
  RawSurface surface;
  Merger merger(surface);
  surface.triangles.reserve(facets);
  for (std::size_t f = 0; f < facets; ++f) {
    file.skip_bytes(12);
    std::array<std::int32_t, 3> triangle;
    for (std::int32_t& corner : triangle)
      corner = merger.index_of(file.position_3d(NumberType::float32));
    file.skip_bytes(2);
    surface.triangles.push_back(triangle);
  }
  return surface;
}

RawSurface read_text(Cursor& file) {
  RawSurface surface;
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

RawSurface read_stl(Cursor& file, RawLabels*) {
  const std::string_view bytes = file.bytes();
  // Binary files may begin with "solid" too, so the exact size decides.
  if (bytes.size() >= kHeader) {
    const auto facets = static_cast<std::size_t>(
        decode_integer(bytes.data() + 80, NumberType::uint32, Encoding::little_endian));
    const bool is_exact = bytes.size() == kHeader + kFacet * facets;
    if (is_exact || !same_word(bytes.substr(0, 5), "solid")) {
      file.encoding = Encoding::little_endian;
      file.seek(80);
      file.skip_bytes(4);
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
