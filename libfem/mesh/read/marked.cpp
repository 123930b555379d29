#include "libfem/mesh/read/read.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr double kSlack = 1e-9;  // of the mesh's extent

using mesh_read::RawLabels;

constexpr std::size_t kListed = 10;

// Flags of a mark in a file: by point or by cell; one of both is there.
struct MarkFlags {
  std::vector<char> points, cells;
};

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kListed); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kListed) text += fmt::format(", and {} more", names.size() - kListed);
  return text;
}

MarkFlags group_of(const RawLabels& labels, const std::string& name, const std::string& where) {
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
  MarkFlags marked;
  marked.cells.assign(labels.cells, 0);
  for (const std::int32_t cell : found->cells) marked.cells[cell] = 1;
  return marked;
}

const std::vector<double>* find_field(const RawLabels& labels, std::string_view name,
                                      bool is_on_points) {
  for (const RawLabels::Field& field : labels.fields)
    if (field.name == name && field.is_on_points == is_on_points) return &field.values;
  return nullptr;
}

MarkFlags colour_of(const RawLabels& labels, const std::string& colour, const std::string& where) {
  const auto parts = [&](bool is_on_points) {
    std::array<const std::vector<double>*, 3> out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = find_field(labels, std::array{"red", "green", "blue"}[i], is_on_points);
    return out;
  };
  const auto are_there = [](const auto& of) { return of[0] && of[1] && of[2]; };
  const bool is_on_points = !are_there(parts(false));
  const auto channels = parts(is_on_points);
  if (!are_there(channels))
    throw Error(where, "has no colours", "Save it as PLY with colours of its faces or vertices.");
  std::map<std::string, std::size_t> known;
  std::vector<char> flags;
  for (std::size_t i = 0; i < channels[0]->size(); ++i) {
    std::string here = "#";
    for (const auto* channel : channels)
      here += fmt::format("{:02x}", static_cast<int>(std::clamp((*channel)[i], 0.0, 255.0)));
    flags.push_back(here == colour);
    ++known[here];
  }
  if (!known.contains(colour)) {
    std::vector<std::pair<std::size_t, std::string>> by_count;
    for (const auto& [name, count] : known) by_count.push_back({count, name});
    std::stable_sort(by_count.begin(), by_count.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::string> names;
    for (const auto& [count, name] : by_count)
      names.push_back(fmt::format("{} ({} {})", name, count, is_on_points ? "vertices" : "faces"));
    throw Error(where, fmt::format("has nothing of colour {}", colour),
                fmt::format("Its colours: {}.", list_of(names)));
  }
  return is_on_points ? MarkFlags{flags, {}} : MarkFlags{{}, flags};
}

MarkFlags field_of(const RawLabels& labels, std::size_t points, const MeshMark& mark,
                   const std::string& where) {
  const auto* on_cells = find_field(labels, mark.name, false);
  const auto* values = on_cells != nullptr ? on_cells : find_field(labels, mark.name, true);
  const auto rows = on_cells != nullptr ? static_cast<std::size_t>(labels.cells) : points;
  if (values == nullptr || values->size() != rows) {
    std::vector<std::string> known;
    for (const RawLabels::Field& field : labels.fields)
      known.push_back(
          fmt::format("\"{}\" (of {})", field.name, field.is_on_points ? "points" : "cells"));
    throw Error(where,
                values == nullptr
                    ? fmt::format("has no field \"{}\"", mark.name)
                    : fmt::format("field \"{}\" has {} numbers for {} {}", mark.name,
                                  values->size(), rows, on_cells != nullptr ? "cells" : "points"),
                known.empty()
                    ? "It has no fields: VTK files have those of points and cells, PLY "
                      "files other properties."
                    : fmt::format("Name a field of one number. Its fields: {}.", list_of(known)));
  }
  std::vector<char> flags;
  std::set<double> known;
  for (const double value : *values) {
    // A float32 differs so much from the number that was typed.
    flags.push_back(std::abs(value - mark.equals) <= 1e-6 * std::max(1.0, std::abs(value)));
    known.insert(value);
  }
  if (std::ranges::count(flags, 1) == 0) {
    std::vector<std::string> names;
    for (const double value : known) names.push_back(fmt::format("{:.6g}", value));
    throw Error(where, fmt::format("field \"{}\" equals {:.6g} nowhere", mark.name, mark.equals),
                fmt::format("Its values: {}.", list_of(names)));
  }
  return on_cells != nullptr ? MarkFlags{{}, flags} : MarkFlags{flags, {}};
}

MarkFlags find_mark(const RawLabels& labels, std::size_t points, const MeshMark& mark,
                    const std::string& where) {
  switch (mark.by) {
    case MeshMark::By::group:
      return group_of(labels, mark.name, where);
    case MeshMark::By::colour:
      return colour_of(labels, mark.name, where);
    case MeshMark::By::field:
      break;
  }
  return field_of(labels, points, mark, where);
}

// Flags of corners, `width` to a cell of `corners`.
template <std::size_t width>
std::vector<char> corner_flags(const MarkFlags& marked,
                               std::span<const std::array<std::int32_t, width>> corners,
                               const std::vector<std::int32_t>& cell) {
  std::vector<char> flags;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (const std::int32_t corner : corners[i])
      flags.push_back(!marked.points.empty() ? marked.points[corner] : marked.cells[cell[i]]);
  return flags;
}

// The boundary of tets, and of it the faces or points that are marked in the file.
PaintedPart marked_boundary(const mesh_read::RawMesh& raw, const RawLabels& labels,
                            const MarkFlags& marked, double length_unit_m, const std::string& where,
                            const MeshMark& mark) {
  std::set<Triangle> painted;  // by sorted corners
  for (std::size_t f = 0; f < labels.faces.size(); ++f)
    if (marked.points.empty() && marked.cells[labels.face_cell[f]]) {
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
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = raw.tets[tet][fem::kTetFace[face][k]];
      flags.push_back(marked.points.empty() ? painted.contains(begin->sorted)
                                            : marked.points[triangle[k]]);
    }
  });
  if (std::ranges::count(flags, 1) == 0)
    throw Error(where, fmt::format("no face of \"{}\" lies on the boundary of the body", mark.name),
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
      slack_m_(kSlack * extent_m(volume_.nodes).norm()),
      interiors_(volume_.tets.rows()) {
  for (Eigen::Index t = 0; t < volume_.tets.rows(); ++t) {
    const auto painted = std::count(&is_painted_[4 * t], &is_painted_[4 * t] + 4, 1);
    if (painted != 0 && painted != 4) continue;
    Interior& tet = interiors_[t];
    for (int k = 0; k < 4; ++k) {
      const auto corner = [&](int i) -> Vec3 {
        return volume_.nodes.row(volume_.tets(t, (k + i) % 4));
      };
      Vec3 inward = (corner(2) - corner(1)).cross(corner(3) - corner(1)).normalized();
      if (inward.dot(corner(0) - corner(1)) < 0) inward = -inward;
      tet.normal.row(k) = inward;
      tet.offset_m[k] = inward.dot(corner(1));
    }
  }
}

// The tets that hold a place decide, unless one of them is painted in part.
std::optional<bool> PaintedPart::decided_by_holders(const Vec3& place) const {
  bool is_any = false, is_painted = false, is_in_part = false;
  double squared_best = slack_m_ * slack_m_;
  boxes_.visit_nearest(place, squared_best, [&](std::int32_t t, double& best) {
    const Interior& tet = interiors_[t];
    if ((tet.normal * place - tet.offset_m).minCoeff() < -slack_m_) return;
    is_any = true;
    is_in_part |= tet.normal.isZero();
    is_painted |= !tet.normal.isZero() && is_painted_[4 * t] != 0;
    if (is_painted) best = -1;  // ends the search
  });
  return is_painted              ? std::optional(true)
         : is_any && !is_in_part ? std::optional(false)
                                 : std::nullopt;
}

bool PaintedPart::contains(const Vec3& place) const {
  const auto is_painted = [&](std::int32_t cell, const auto& weight) {
    double painted = 0;
    for (Eigen::Index k = 0; k < weight.size(); ++k)
      if (is_painted_[weight.size() * cell + k]) painted += weight[k];
    return painted >= 0.5 - 1e-9;
  };
  // The nearest place decides, and of places as near one that is painted.
  const auto decide = [&](const auto& nearest) {
    const auto any =
        nearest(std::numeric_limits<double>::infinity(), [](const auto&) { return true; });
    return any && nearest(any->distance_m + slack_m_, [&](const auto& at) {
                    if constexpr (requires { at.tet; })
                      return is_painted(at.tet, at.weight);
                    else
                      return is_painted(at.triangle, at.weight);
                  }).has_value();
  };
  if (is_on_faces())
    return decide([&](double max_m, auto accept) {
      return closest_point(surface_, boxes_, place, max_m, accept);
    });
  if (const auto decided = decided_by_holders(place)) return *decided;
  return decide([&](double max_m, auto accept) {
    return closest_in_volume(volume_, boxes_, place, max_m, accept);
  });
}

PaintedPart read_marked_part(const std::filesystem::path& path, double length_unit_m, bool is_tets,
                             const MeshMark& mark) {
  const std::string where = path.string();
  RawLabels labels;
  const mesh_read::RawMesh raw = mesh_read::read_raw(path, is_tets, &labels);
  const MarkFlags marked = find_mark(labels, raw.points.size(), mark, where);
  if (!is_tets)
    return {Surface{length_unit_m * rows_of(raw.points), rows_of(raw.triangles)},
            corner_flags<3>(marked, raw.triangles, labels.cell)};
  std::vector<char> flags = corner_flags<4>(marked, raw.tets, labels.cell);
  bool has_full_tet = false;
  for (std::size_t t = 0; t < raw.tets.size(); ++t)
    has_full_tet |=
        std::all_of(&flags[4 * t], &flags[4 * t] + 4, [](char flag) { return flag != 0; });
  if (!has_full_tet) return marked_boundary(raw, labels, marked, length_unit_m, where, mark);
  return {TetMesh{length_unit_m * rows_of(raw.points), rows_of(raw.tets), {}}, std::move(flags)};
}

}  // namespace palpate
