#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libfem/mesh/repair/soup.hpp"

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
  explicit SurfaceParts(const Soup& soup) : soup_(soup), of_face_(components(soup.faces)) {
    parts_.resize(of_face_.number);
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
      SurfacePart& part = parts_[of_face_.of_face[f]];
      part.faces.push_back(soup.faces[f]);
      for (const std::int32_t v : soup.faces[f])
        part.box.extend(soup.points[static_cast<std::size_t>(v)]);
    }
    for (SurfacePart& part : parts_) {
      close(part);
      part.volume_m3 = volume_of(part);
    }
  }

  // Whether each component must be turned: outside ones outward, those inside an odd number inward.
  std::vector<char> to_turn() const {
    std::vector<char> turn(parts_.size(), 0);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      int depth = 0;
      const Vec3 point = soup_.points[static_cast<std::size_t>(parts_[p].faces.front()[0])];
      for (std::size_t other = 0; other < parts_.size(); ++other)
        depth += other != p && parts_[other].box.contains(parts_[p].box) &&
                 std::abs(winding_number(parts_[other], point)) > 0.5;
      turn[p] = (parts_[p].volume_m3 < 0) != (depth % 2 == 1);
      if (parts_[p].volume_m3 == 0) turn[p] = 0;
    }
    return turn;
  }

  std::size_t of_face(std::size_t face) const { return of_face_.of_face[face]; }

 private:
  Vec3 at(const SurfacePart& part, std::int32_t v) const {
    const auto i = static_cast<std::size_t>(v);
    return i < soup_.points.size() ? soup_.points[i] : part.points[i - soup_.points.size()];
  }

  // All borders of a part meet in one middle: the fans' inner edges cancel where borders are loops.
  void close(SurfacePart& part) const {
    std::vector<Triangle> fan;
    Vec3 sum = Vec3::Zero();
    const auto middle = static_cast<std::int32_t>(soup_.points.size());
    for_each_edge(sorted_sides(part.faces), [&](auto begin, auto end) {
      if (end - begin != 1) return;
      const Triangle& face = part.faces[static_cast<std::size_t>(begin->face)];
      const auto k = static_cast<std::size_t>(begin->corner);
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

void orient_outward(Soup& soup, Changes& changes) {
  const SurfaceParts parts(soup);
  const std::vector<char> turn = parts.to_turn();
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    if (!turn[parts.of_face(f)]) continue;
    std::swap(soup.faces[f][1], soup.faces[f][2]);
    soup.is_turned[f] ^= 1;
  }
  const auto turned = static_cast<std::size_t>(std::ranges::count(soup.is_turned, 1));
  if (turned > 0)
    changes.push_back("turned " + counted(turned, "triangle", "triangles") + " outward");
}

}  // namespace palpate::repair
