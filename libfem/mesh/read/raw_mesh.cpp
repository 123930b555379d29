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

}  // namespace

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

}  // namespace palpate::mesh_read
