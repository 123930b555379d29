#include "libfem/mesh/read/raw_mesh.hpp"

#include <string>

namespace palpate::mesh_read {
namespace {

std::int32_t checked_index(std::int64_t index, std::size_t points, const Cursor& cursor) {
  if (index < 0 || static_cast<std::uint64_t>(index) >= points)
    cursor.fail("an element uses vertex " + std::to_string(index) +
                " (counted from 0), but there are " + std::to_string(points) + " vertices");
  return static_cast<std::int32_t>(index);
}

}  // namespace

void add_polygon(RawSurface& surface, std::span<const std::int64_t> corners, const Cursor& cursor) {
  if (corners.size() < 3)
    cursor.fail("a face has " + std::to_string(corners.size()) + " corners, needs at least 3");
  const std::size_t points = surface.points.size();
  const std::int32_t first = checked_index(corners[0], points, cursor);
  std::int32_t previous = checked_index(corners[1], points, cursor);
  for (const std::int64_t corner : corners.subspan(2)) {
    const std::int32_t next = checked_index(corner, points, cursor);
    surface.triangles.push_back({first, previous, next});
    previous = next;
  }
}

void add_tet(RawTetMesh& mesh, std::span<const std::int64_t, 4> corners, std::int64_t id,
             const Cursor& cursor) {
  std::array<std::int32_t, 4> tet;
  for (std::size_t i = 0; i < 4; ++i)
    tet[i] = checked_index(corners[i], mesh.points.size(), cursor);
  mesh.tets.push_back(tet);
  mesh.tet_id.push_back(id);
}

void fail_not_tets(const Cursor& cursor, const char* kind) {
  cursor.fail(std::string("the mesh holds volume elements that are not tetrahedra: ") + kind,
              "Mesh the volume with tetrahedra only, or give its surface instead.");
}

}  // namespace palpate::mesh_read
