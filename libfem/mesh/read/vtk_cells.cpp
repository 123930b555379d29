#include "libfem/mesh/read/raw_mesh.hpp"

#include <algorithm>
#include <span>
#include <string>

namespace palpate::mesh_read {
namespace {

// Calls use(cell, corners) with each cell's corners as indices into the whole mesh's points.
template <typename Use>
void for_each_cell(const VtkCells& cells, std::size_t base, const Cursor& cursor, Use use) {
  std::vector<std::int64_t> corners;
  std::int64_t begin = 0;
  for (std::size_t cell = 0; cell < cells.end.size(); ++cell) {
    const std::int64_t end = cells.end[cell];
    if (end < begin || end > static_cast<std::int64_t>(cells.connectivity.size()))
      cursor.fail("cell " + std::to_string(cell) + " has offsets outside the connectivity");
    corners.assign(cells.connectivity.begin() + begin, cells.connectivity.begin() + end);
    for (std::int64_t& corner : corners) {
      if (corner < 0 || corner > INT32_MAX)
        corner = INT32_MAX;  // refused by the range check
      else
        corner += static_cast<std::int64_t>(base);
    }
    use(cell, std::span<const std::int64_t>(corners));
    begin = end;
  }
}

enum class CellKind { tet, ignored, other_volume };

CellKind kind_of(std::int64_t type) {
  constexpr std::int64_t kTets[] = {10, 24, 71};
  // Points, lines, triangles, quads and polygons, also quadratic and Lagrange.
  constexpr std::int64_t kFlat[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9, 21,
                                    22, 23, 28, 30, 34, 35, 36, 68, 69, 70};
  if (std::ranges::count(kTets, type) > 0) return CellKind::tet;
  return std::ranges::count(kFlat, type) > 0 ? CellKind::ignored : CellKind::other_volume;
}

}  // namespace

void add_polygons(RawSurface& surface, const VtkCells& cells, std::size_t base,
                  const Cursor& cursor) {
  for_each_cell(cells, base, cursor, [&](std::size_t, std::span<const std::int64_t> corners) {
    add_polygon(surface, corners, cursor);
  });
}

void add_strips(RawSurface& surface, const VtkCells& cells, std::size_t base,
                const Cursor& cursor) {
  for_each_cell(cells, base, cursor, [&](std::size_t, std::span<const std::int64_t> corners) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
      std::array<std::int64_t, 3> triangle{corners[i - 2], corners[i - 1], corners[i]};
      if (i % 2 == 1) std::swap(triangle[0], triangle[1]);
      add_polygon(surface, triangle, cursor);
    }
  });
}

void note_cells(const VtkCells& cells, RawLabels& labels) {
  std::int64_t begin = 0;
  for (const std::int64_t end : cells.end) {
    labels.add_cell(std::max<std::int64_t>(end - begin - 2, 0));
    begin = end;
  }
}

void add_tets(RawTetMesh& mesh, const VtkCells& cells, const std::vector<std::int64_t>& types,
              std::size_t base, const Cursor& cursor, RawLabels* labels) {
  constexpr std::int64_t kTriangles[] = {5, 22, 34, 69};
  if (types.size() != cells.end.size())
    cursor.fail("there are " + std::to_string(cells.end.size()) + " cells but " +
                std::to_string(types.size()) + " cell types");
  for_each_cell(cells, base, cursor, [&](std::size_t cell, std::span<const std::int64_t> corners) {
    switch (kind_of(types[cell])) {
      case CellKind::ignored:
        ++mesh.ignored_elements;
        if (labels != nullptr && std::ranges::count(kTriangles, types[cell]) > 0 &&
            corners.size() >= 3)
          labels->add_face(corners, labels->cells + static_cast<std::int32_t>(cell));
        break;
      case CellKind::other_volume:
        fail_not_tets(cursor, ("VTK cell type " + std::to_string(types[cell])).c_str());
      case CellKind::tet:
        if (corners.size() < 4) cursor.fail("a tetrahedron has fewer than 4 corners");
        add_tet(mesh, corners.first<4>(), static_cast<std::int64_t>(cell), cursor);
        if (labels != nullptr)
          labels->cell.push_back(labels->cells + static_cast<std::int32_t>(cell));
    }
  });
  if (labels != nullptr) labels->cells += static_cast<std::int32_t>(types.size());
}

}  // namespace palpate::mesh_read
