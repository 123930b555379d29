#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::repair {
namespace {

struct SurfacePart {
  std::vector<Triangle> faces;  // and a fan over each border, so that it is closed
  std::vector<Vec3> points;     // middles of borders, numbered after the soup's points
  Eigen::AlignedBox3d box;
  double volume_m3 = 0;
};

class SurfaceParts {
 public:
  explicit SurfaceParts(const Soup& soup) : soup_(soup), of_face_(components(rows_of(soup.faces))) {
    parts_.resize(of_face_.number);
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
      SurfacePart& part = parts_[of_face_.of_face[f]];
      part.faces.push_back(soup.faces[f]);
      for (const std::int32_t v : soup.faces[f]) part.box.extend(soup.points[v]);
    }
    for (SurfacePart& part : parts_) {
      close(part);
      part.volume_m3 = volume_of(part);
    }
  }

  // A component may have to be turned, and may bound nothing. A shell inside the
  // body that points as the body's own surface does has the body on both its sides.
  struct PartRole {
    bool is_turned = false;
    bool is_cavity = false;
    bool is_inside = false;  // bounds nothing
  };
  std::vector<PartRole> roles() const {
    const std::vector<std::vector<std::size_t>> around = parts_around();
    std::vector<std::size_t> outside_in(parts_.size());
    std::iota(outside_in.begin(), outside_in.end(), std::size_t{0});
    const auto depth = [&](std::size_t p) { return around[p].size(); };
    std::ranges::stable_sort(outside_in, {}, depth);
    std::vector<PartRole> roles(parts_.size());
    std::vector<char> is_solid(parts_.size(), 1);  // just inside of each
    for (const std::size_t p : outside_in) {
      if (parts_[p].volume_m3 == 0) continue;
      bool is_in_body = false, is_body_turned = false;
      if (!around[p].empty()) {
        is_in_body = is_solid[std::ranges::max(around[p], {}, depth)] != 0;
        is_body_turned = parts_[std::ranges::min(around[p], {}, depth)].volume_m3 < 0;
      }
      const bool is_inward = (parts_[p].volume_m3 < 0) != is_body_turned;
      roles[p].is_inside = is_in_body && !is_inward;
      roles[p].is_cavity = is_in_body && is_inward;
      is_solid[p] = !roles[p].is_cavity;
      roles[p].is_turned = (parts_[p].volume_m3 < 0) != roles[p].is_cavity;
    }
    return roles;
  }

  const SurfacePart& of_number(std::size_t part) const { return parts_[part]; }
  std::size_t of_face(std::size_t face) const { return of_face_.of_face[face]; }

 private:
  // The parts that each lies in, whole.
  std::vector<std::vector<std::size_t>> parts_around() const {
    std::vector<std::vector<std::size_t>> around(parts_.size());
    for (std::size_t outer = 0; outer < parts_.size(); ++outer) {
      std::optional<TriangleTree> walls;  // made once, and only for parts with others in their box
      for (std::size_t p = 0; p < parts_.size(); ++p) {
        const Vec3 point = soup_.points[parts_[p].faces.front()[0]];
        if (p == outer || !parts_[outer].box.contains(parts_[p].box) ||
            !(std::abs(winding_number(parts_[outer], point)) > 0.5))
          continue;
        if (!walls) walls.emplace(tree_of(parts_[outer]));
        if (!has_edge_through(parts_[p], *walls, parts_[outer].box) &&
            !has_edge_through(parts_[outer], tree_of(parts_[p]), parts_[p].box))
          around[p].push_back(outer);
      }
    }
    return around;
  }

  struct TriangleTree {
    Surface surface;
    BoxTree boxes;
  };
  TriangleTree tree_of(const SurfacePart& part) const {
    std::vector<Vec3> points = soup_.points;
    points.insert(points.end(), part.points.begin(), part.points.end());
    TriangleTree tree{{rows_of(points), rows_of(part.faces)}, {}};
    tree.boxes = triangle_boxes(tree.surface);
    return tree;
  }

  // box: of what is in the tree.
  bool has_edge_through(const SurfacePart& part, const TriangleTree& tree,
                        const Eigen::AlignedBox3d& box) const {
    for (const Triangle& face : part.faces)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 from = at(part, face[k]), to = at(part, face[(k + 1) % 3]);
        Eigen::AlignedBox3d edge(from);
        if (!edge.extend(to).intersects(box)) continue;
        const double length_m = (to - from).norm();
        bool is_through = false;
        const auto comes_near = [&](const Vec3& centre, double half_diagonal_m) {
          return !is_through && (centre - (from + to) / 2).norm() <= half_diagonal_m + length_m / 2;
        };
        tree.boxes.visit_where(comes_near, [&](std::int32_t f) {
          const auto [a, b, c] = corners_of(tree.surface, f);
          const double hit_m = ray_hit_m(from, (to - from) / length_m, a, b, c);
          is_through |= hit_m >= 0 && hit_m <= length_m;
        });
        if (is_through) return true;
      }
    return false;
  }

  Vec3 at(const SurfacePart& part, std::int32_t v) const {
    const auto i = static_cast<std::size_t>(v);
    return i < soup_.points.size() ? soup_.points[i] : part.points[i - soup_.points.size()];
  }

  // All borders of a part meet in one middle: the fans' inner edges cancel where borders are loops.
  void close(SurfacePart& part) const {
    std::vector<Triangle> fan;
    Vec3 sum = Vec3::Zero();
    const auto middle = static_cast<std::int32_t>(soup_.points.size());
    for_each_edge(sorted_sides(rows_of(part.faces)), [&](auto begin, auto end) {
      if (end - begin != 1) return;
      const Triangle& face = part.faces[begin->face];
      const int k = begin->corner;
      fan.push_back({face[(k + 1) % 3], face[k], middle});
      sum += at(part, face[k]);
    });
    if (fan.empty()) return;
    part.points.push_back(sum / static_cast<double>(fan.size()));
    part.faces.insert(part.faces.end(), fan.begin(), fan.end());
  }

  double volume_of(const SurfacePart& part) const {
    const Vec3 origin = at(part, part.faces.front()[0]);
    double sum = 0;
    for (const Triangle& f : part.faces)
      sum +=
          (at(part, f[0]) - origin).dot((at(part, f[1]) - origin).cross(at(part, f[2]) - origin)) /
          6;
    return sum;
  }

  // Solid angle over 4 pi: Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207.
  double winding_number(const SurfacePart& part, const Vec3& point) const {
    double angle = 0;
    for (const Triangle& f : part.faces) {
      const Vec3 a = at(part, f[0]) - point, b = at(part, f[1]) - point, c = at(part, f[2]) - point;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      angle += 2 * std::atan2(a.dot(b.cross(c)),
                              la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return angle / (4 * std::numbers::pi);
  }

  const Soup& soup_;
  Components of_face_;
  std::vector<SurfacePart> parts_;
};

}  // namespace

void drop_stray_facets(Soup& soup, Changes& changes, const std::string& where) {
  const std::vector<TriangleSide> sides = sorted_sides(rows_of(soup.faces));
  DisjointSets sheets(soup.faces.size());
  for_each_edge(sides, [&](auto begin, auto end) {
    if (end - begin == 2) sheets.join(begin->face, (begin + 1)->face);
  });
  const auto sheet_of = [&](const TriangleSide& side) { return sheets.find(side.face); };
  std::vector<char> is_open(soup.faces.size(), 0);
  for_each_edge(sides, [&](auto begin, auto end) {
    if (end - begin == 1) is_open[sheet_of(*begin)] = 1;
  });
  Soup open = soup;
  std::vector<char> keep(soup.faces.size());
  std::vector<std::size_t> number_of;  // of each face of `open`, in the soup
  for (std::size_t f = 0; f < keep.size(); ++f)
    if ((keep[f] = is_open[sheets.find(f)])) number_of.push_back(f);
  keep_faces(open, keep);
  bool is_body_closed = open.faces.size() < soup.faces.size();
  for_each_edge(sides, [&](auto begin, auto end) {
    const auto of_body = [&](const TriangleSide& side) { return !is_open[sheet_of(side)]; };
    if (std::count_if(begin, end, of_body) == 1) is_body_closed = false;
  });
  if (open.faces.empty() || !is_body_closed) return;

  Eigen::AlignedBox3d body;
  for (std::size_t f = 0; f < soup.faces.size(); ++f)
    if (!keep[f])
      for (const std::int32_t v : soup.faces[f]) body.extend(soup.points[v]);
  Changes unreported;
  make_manifold(open, unreported, where);
  const SurfaceParts pieces(open);
  std::vector<char> is_kept(soup.faces.size(), 1);
  // Least share of the volume of the body's box that a piece with a border encloses, closed by a
  // fan, as a part of the body that lost a lid: a bag of a tenth of the body's length. A facet has
  // 0, a dozen bent ones some 1e-5; a gall bladder beside its liver 0.01. Half and twice: 0.08 and
  // 0.13 of the length.
  for (std::size_t f = 0; f < open.faces.size(); ++f)
    if (std::abs(pieces.of_number(pieces.of_face(f)).volume_m3) < 1e-3 * body.volume())
      is_kept[number_of[f]] = 0;
  if (const std::size_t dropped = keep_faces(soup, is_kept))
    changes.push_back("dropped " + counted(dropped, "stray triangle", "stray triangles") +
                      " with open borders, beside or on a body that is closed without");
}

void orient_outward(Soup& soup, Changes& changes) {
  const SurfaceParts parts(soup);
  const auto roles = parts.roles();
  std::vector<char> keep(soup.faces.size(), 1);
  std::size_t outward = 0, inward = 0;
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    const auto& role = roles[parts.of_face(f)];
    keep[f] = !role.is_inside;
    if (!keep[f]) continue;
    if (role.is_turned) {
      std::swap(soup.faces[f][1], soup.faces[f][2]);
      soup.is_turned[f] ^= 1;
    }
    (role.is_cavity ? inward : outward) += soup.is_turned[f];
  }
  if (outward > 0)
    changes.push_back("turned " + counted(outward, "triangle", "triangles") + " outward");
  if (inward > 0)
    changes.push_back("turned " + counted(inward, "triangle", "triangles") + " of a cavity inward");
  std::int64_t shells = 0, triangles = 0;
  double volume_m3 = 0;
  std::string at;
  for (std::size_t p = 0; p < roles.size(); ++p) {
    if (!roles[p].is_inside) continue;
    const SurfacePart& shell = parts.of_number(p);
    if (shells++ == 0) at = coordinates(shell.box.center());
    triangles += static_cast<std::int64_t>(shell.faces.size());
    volume_m3 += std::abs(shell.volume_m3);
  }
  if (shells > 0)
    changes.push_back(
        "left out " + counted(shells, "shell", "shells") + " inside the body (" +
        counted(triangles, "triangle", "triangles") + ", " + number(1e6 * volume_m3) + " ml, " +
        (shells > 1 ? "the first at " : "at ") + at +
        "), pointing outward as the body's own surface does: the body is solid there. For a lesion "
        "name it in a file of its own by inside = in [[inclusion]]; for a cavity turn it inward");
  keep_faces(soup, keep);
}

}  // namespace palpate::repair
