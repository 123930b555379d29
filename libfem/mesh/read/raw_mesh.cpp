#include "libfem/mesh/read/raw_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::mesh_read {

namespace {

std::int32_t checked_index(std::int64_t index, std::size_t points, const Cursor& cursor) {
  if (index < 0 || static_cast<std::uint64_t>(index) >= points)
    cursor.fail("an element uses vertex " + std::to_string(index) +
                " (counted from 0), but there are " + std::to_string(points) + " vertices");
  return static_cast<std::int32_t>(index);
}

using TetIds = std::array<std::int32_t, 4>;

std::string list_of(std::span<const std::int64_t> ids) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(ids.size(), 8); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(ids[i]);
  return ids.size() > 8 ? text + ", ... (" + std::to_string(ids.size()) + " in all)" : text;
}

// Six times the signed volume over the longest edge cubed; 0 for a tet of one point.
double relative_volume(const std::vector<Vec3>& points, const TetIds& tet) {
  std::array<Vec3, 4> p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = points[tet[i]];
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (p[i] - p[j]).norm());
  if (longest == 0) return 0;
  const Vec3 a = (p[1] - p[0]) / longest, b = (p[2] - p[0]) / longest, c = (p[3] - p[0]) / longest;
  return a.cross(b).dot(c) / 6;
}

// Drops tets with the corners of an earlier one, in whatever order.
void drop_duplicates(RawMesh& raw, TetReadNotes& notes) {
  const std::vector<char> is_repeat = repeats(raw.tets);
  std::vector<std::int64_t> dropped;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < is_repeat.size(); ++t) {
    if (is_repeat[t]) {
      dropped.push_back(raw.tet_id[t]);
      continue;
    }
    raw.tets[kept] = raw.tets[t];
    raw.tet_id[kept++] = raw.tet_id[t];
  }
  raw.tets.resize(kept);
  raw.tet_id.resize(kept);
  notes.duplicate_tets = list_of(dropped);
}

std::vector<TetIds> turned_positive(const RawMesh& raw, const std::string& where,
                                    TetReadNotes& notes) {
  std::vector<TetIds> tets = raw.tets;
  std::vector<std::int64_t> flat;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const double volume = relative_volume(raw.points, tets[t]);
    // Volume over longest edge cubed below which a tet counts as flat: roundoff of a tet written
    // with 12 digits, and far below slivers that still solve (quality 0.0015).
    if (!(std::abs(volume) > 1e-12)) flat.push_back(raw.tet_id[t]);
    if (volume >= 0) continue;
    std::swap(tets[t][2], tets[t][3]);
    ++notes.flipped_tets;
  }
  if (!flat.empty())
    throw Error(where, "tetrahedra without volume: " + list_of(flat),
                "Mesh the body again with the mesher's optimisation on, or give its surface.");
  return tets;
}

// Positive tets that share a face lie on opposite sides of it exactly when they see it in opposite
// orders: a tet that was inside out because a node crossed its far face is found here.
void refuse_overlaps(const RawMesh& raw, const std::vector<TetIds>& tets,
                     const std::string& where) {
  std::vector<std::int64_t> overlapping;
  fem::for_each_face(fem::sorted_faces(rows_of(tets)), [&](auto begin, auto end) {
    if (end - begin > 2 || (end - begin == 2 && begin->is_even == (begin + 1)->is_even))
      for (auto face = begin; face < end; ++face) overlapping.push_back(raw.tet_id[face->of.tet]);
  });
  if (overlapping.empty()) return;
  sort_unique(overlapping);
  throw Error(where, "tetrahedra overlap their neighbours: " + list_of(overlapping),
              "The mesh is tangled: mesh the body again, or give its surface.");
}

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

void RawLabels::add_face(std::span<const std::int64_t> corners, std::int32_t of_cell) {
  std::array<std::int32_t, 3>& face = faces.emplace_back();
  std::copy_n(corners.begin(), 3, face.begin());
  face_cell.push_back(of_cell);
}

RawLabels::Field& RawLabels::field(std::string_view name, bool is_on_points) {
  for (Field& known : fields)
    if (known.name == name && known.is_on_points == is_on_points) return known;
  return fields.emplace_back(Field{std::string(name), is_on_points, {}});
}

RawLabels::Group& RawLabels::group(std::string_view name, int dimension) {
  for (Group& known : groups)
    if (known.name == name && known.dimension == dimension) return known;
  return groups.emplace_back(Group{std::string(name), dimension, {}});
}

void add_polygon(RawMesh& surface, std::span<const std::int64_t> corners, const Cursor& cursor) {
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

void add_tet(RawMesh& mesh, std::span<const std::int64_t, 4> corners, std::int64_t id,
             const Cursor& cursor) {
  std::array<std::int32_t, 4> tet;
  for (std::size_t i = 0; i < 4; ++i)
    tet[i] = checked_index(corners[i], mesh.points.size(), cursor);
  mesh.tets.push_back(tet);
  mesh.tet_id.push_back(id);
}

void fail_not_tets(const Cursor& cursor, std::string_view kind) {
  cursor.fail("the mesh holds volume elements that are not tetrahedra: " + std::string(kind),
              "Mesh the volume with tetrahedra only, or give its surface instead.");
}

TetMesh settle_tets(RawMesh raw, double length_unit_m, const std::string& where,
                    TetReadNotes& notes) {
  drop_duplicates(raw, notes);
  std::vector<TetIds> tets = turned_positive(raw, where, notes);
  refuse_overlaps(raw, tets, where);
  const auto used =
      renumber({tets.front().data(), 4 * tets.size()}, raw.points.size(), Numbering::ascending);
  notes.dropped_nodes = raw.points.size() - used.size();
  return {length_unit_m * rows_of(raw.points)(used, Eigen::all), rows_of(tets), {}};
}

void add_polygons(RawMesh& surface, const VtkCells& cells, std::size_t base, const Cursor& cursor) {
  for_each_cell(cells, base, cursor, [&](std::size_t, std::span<const std::int64_t> corners) {
    add_polygon(surface, corners, cursor);
  });
}

void add_strips(RawMesh& surface, const VtkCells& cells, std::size_t base, const Cursor& cursor) {
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

void add_tets(RawMesh& mesh, const VtkCells& cells, const std::vector<std::int64_t>& types,
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
        fail_not_tets(cursor, "VTK cell type " + std::to_string(types[cell]));
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
