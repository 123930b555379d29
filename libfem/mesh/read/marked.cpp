#include "libfem/mesh/read/read.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr double kSlack = 1e-9;  // of the mesh's extent

using mesh_read::RawLabels;

std::string list_of(const std::vector<std::string>& names) {
  const std::size_t listed = std::min<std::size_t>(names.size(), 10);  // a few lines of a terminal
  const std::string text =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + listed, ", "));
  return listed == names.size() ? text
                                : fmt::format("{}, and {} more", text, names.size() - listed);
}

// Flags of the file's cells.
std::vector<char> cells_of_group(const RawLabels& labels, const std::string& name,
                                 const std::string& where) {
  constexpr const char* kOf[] = {"points", "curves", "faces", "tetrahedra"};
  const RawLabels::Group* found = nullptr;
  std::vector<std::string> known;
  for (const RawLabels::Group& group : labels.groups) {
    known.push_back(
        fmt::format("\"{}\" ({} {})", group.name, group.cells.size(), kOf[group.dimension]));
    // Tetrahedra before their faces, where a name means both.
    if (group.name == name && (found == nullptr || group.dimension > found->dimension))
      found = &group;
  }
  if (found == nullptr)
    throw Error(where, fmt::format("has no group \"{}\"", name),
                known.empty() ? "It has no groups: MSH files have physical groups, OBJ files g, o "
                                "and usemtl."
                              : fmt::format("Its groups: {}.", list_of(known)));
  if (found->dimension < 2)
    throw Error(where, fmt::format("group \"{}\" is of {}", name, kOf[found->dimension]),
                fmt::format("Name one of faces or tetrahedra. Its groups: {}.", list_of(known)));
  std::vector<char> is_marked(labels.cells, 0);
  for (const std::int32_t cell : found->cells) is_marked[cell] = 1;
  return is_marked;
}

// The boundary of tets, and of it the faces that are marked in the file.
PaintedPart marked_boundary(const mesh_read::RawMesh& raw, const RawLabels& labels,
                            const std::vector<char>& is_marked, double length_unit_m,
                            const std::string& where, const std::string& group) {
  std::set<Triangle> painted;  // by sorted corners
  for (std::size_t f = 0; f < labels.faces.size(); ++f)
    if (is_marked[labels.face_cell[f]]) {
      Triangle face = labels.faces[f];
      std::ranges::sort(face);
      painted.insert(face);
    }
  std::vector<Triangle> triangles;
  std::vector<char> flags;
  fem::for_each_face(fem::sorted_faces(rows_of(raw.tets)), [&](auto begin, auto end) {
    if ((end - begin) % 2 == 0) return;  // an inner face, or that of a tet that is there twice
    const auto [tet, face] = (end - 1)->of;
    Triangle& triangle = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = raw.tets[tet][fem::kTetFace[face][k]];
    flags.push_back(painted.contains(begin->sorted));
  });
  if (std::ranges::count(flags, 1) == 0)
    throw Error(where, fmt::format("no face of \"{}\" lies on the boundary of the body", group),
                "Name a group of faces on its boundary, or one of tetrahedra.");
  return {Surface{length_unit_m * rows_of(raw.points), rows_of(triangles)}, std::move(flags)};
}

}  // namespace

PaintedPart::PaintedPart(Surface surface, std::vector<char> is_painted)
    : surface_(std::move(surface)),
      is_painted_(std::move(is_painted)),
      boxes_(triangle_boxes(surface_)),
      slack_m_(kSlack * extent_m(surface_.vertices).norm()) {}

PaintedPart::PaintedPart(TetMesh volume, std::vector<char> is_painted)
    : volume_(std::move(volume)),
      is_painted_(std::move(is_painted)),
      boxes_(boxes_of(volume_.nodes, volume_.tets)),
      slack_m_(kSlack * extent_m(volume_.nodes).norm()) {}

bool PaintedPart::contains(const Vec3& place) const {
  // The nearest cell decides, and of cells as near one that is painted.
  const auto decide = [&](const auto& nearest) {
    const auto any =
        nearest(std::numeric_limits<double>::infinity(), [](const auto&) { return true; });
    return any && nearest(any->distance_m + slack_m_, [&](const auto& at) {
                    if constexpr (requires { at.tet; })
                      return is_painted_[at.tet] != 0;
                    else
                      return is_painted_[at.triangle] != 0;
                  }).has_value();
  };
  if (is_on_faces())
    return decide([&](double max_m, auto accept) {
      return closest_point(surface_, boxes_, place, max_m, accept);
    });
  return decide([&](double max_m, auto accept) {
    return closest_in_volume(volume_, boxes_, place, max_m, accept);
  });
}

PaintedPart read_group(const std::filesystem::path& path, double length_unit_m, bool is_tets,
                       const std::string& group) {
  const std::string where = path.string();
  RawLabels labels;
  const mesh_read::RawMesh raw = mesh_read::read_raw(path, is_tets, &labels);
  const std::vector<char> is_marked = cells_of_group(labels, group, where);
  std::vector<char> flags;
  for (const std::int32_t cell : labels.cell) flags.push_back(is_marked[cell]);
  if (!is_tets)
    return {Surface{length_unit_m * rows_of(raw.points), rows_of(raw.triangles)}, std::move(flags)};
  if (std::ranges::count(flags, 1) == 0)
    return marked_boundary(raw, labels, is_marked, length_unit_m, where, group);
  return {TetMesh{length_unit_m * rows_of(raw.points), rows_of(raw.tets), {}}, std::move(flags)};
}

}  // namespace palpate
