#include "libfem/mesh/grade/smooth_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::fem {
namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;

// A corner of a part, with its weights in the undivided triangle.
struct PartCorner {
  std::int32_t vertex;
  Vec3 weights;
};

// A triangle, or a part of one.
struct FacePart {
  std::int32_t of;
  std::array<PartCorner, 3> corner;

  const PartCorner& next(std::size_t k) const { return corner[(k + 1) % 3]; }
  Edge edge(std::size_t k) const { return std::minmax(corner[k].vertex, next(k).vertex); }
  Vec3 middle(std::size_t k) const { return (corner[k].weights + next(k).weights) / 2; }
};

// Middle of a cut edge, as the mean over its faces.
struct EdgeMiddle {
  Vec3 sum = Vec3::Zero();
  int faces = 0;
  std::int32_t vertex = -1;
};

class Division {
 public:
  explicit Division(const SmoothSurface& smooth) : smooth_(smooth) {
    const Surface& surface = smooth.surface();
    for (const auto& p : surface.vertices.rowwise()) places_.emplace_back(p);
    for (std::int32_t f = 0; f < surface.triangles.rows(); ++f) {
      FacePart face{f, {}};
      for (int k = 0; k < 3; ++k) face.corner[k] = {surface.triangles(f, k), Vec3::Unit(k)};
      faces_.push_back(face);
    }
  }

  // Cuts the longest edges of what is too large, and says whether there was any.
  bool cut_once(const IsDivided& is_divided, const DivisionLimits& limits) {
    cut_.clear();
    for (FacePart& face : faces_) {
      turn_longest_first(face);
      if (is_too_large(face, limits) &&
          is_divided(face.of, place(face, 0), place(face, 1), place(face, 2)))
        cut_.try_emplace(face.edge(0));
    }
    if (cut_.empty()) return false;
    spread();
    place_middles();
    std::vector<FacePart> faces;
    for (const FacePart& face : faces_) append_parts(face, faces);
    faces_ = std::move(faces);
    return true;
  }

  Surface surface() const {
    std::vector<Triangle> corners;
    for (const FacePart& face : faces_)
      corners.push_back({face.corner[0].vertex, face.corner[1].vertex, face.corner[2].vertex});
    return {rows_of(places_), rows_of(corners)};
  }

 private:
  const Vec3& place(std::int32_t v) const { return places_[v]; }
  const Vec3& place(const FacePart& face, std::size_t k) const {
    return place(face.corner[k].vertex);
  }
  double squared(const Edge& edge) const {
    return (place(edge.first) - place(edge.second)).squaredNorm();
  }
  Vec3 lifted_middle(const FacePart& face, std::size_t k) const {
    return smooth_.lifted(face.of, face.middle(k));
  }
  bool is_too_large(const FacePart& face, const DivisionLimits& limits) const {
    const double longest = squared(face.edge(0));
    if (longest > limits.longest_m * limits.longest_m) return true;
    if (longest <= limits.shortest_m * limits.shortest_m) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 chord = (smooth_.lifted(face.of, face.corner[k].weights) +
                          smooth_.lifted(face.of, face.next(k).weights)) /
                         2;
      if ((lifted_middle(face, k) - chord).norm() > limits.sagitta_m) return true;
    }
    return false;
  }
  // Among edges of one length the one with the lower vertices is first, so that both its triangles
  // choose alike.
  void turn_longest_first(FacePart& face) const {
    std::size_t longest = 0;
    const auto rank = [&](std::size_t k) {
      return std::pair(-squared(face.edge(k)), face.edge(k));
    };
    for (std::size_t k = 1; k < 3; ++k)
      if (rank(k) < rank(longest)) longest = k;
    std::rotate(face.corner.begin(), face.corner.begin() + longest, face.corner.end());
  }
  // A triangle that is cut at all is cut at its longest edge.
  void spread() {
    for (bool is_stable = false; !is_stable;) {
      is_stable = true;
      for (const FacePart& face : faces_)
        if (!cut_.contains(face.edge(0)) &&
            (cut_.contains(face.edge(1)) || cut_.contains(face.edge(2)))) {
          cut_.try_emplace(face.edge(0));
          is_stable = false;
        }
    }
  }
  void place_middles() {
    for (const FacePart& face : faces_)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto cut = cut_.find(face.edge(k));
        if (cut == cut_.end()) continue;
        cut->second.sum += lifted_middle(face, k);
        ++cut->second.faces;
      }
    for (auto& [edge, middle] : cut_) {
      middle.vertex = static_cast<std::int32_t>(places_.size());
      places_.push_back(middle.sum / middle.faces);
    }
  }
  // From the middle of the longest edge to the far corner, then each half at its own cut.
  void append_parts(const FacePart& face, std::vector<FacePart>& out) const {
    const auto longest = cut_.find(face.edge(0));
    if (longest == cut_.end()) {
      out.push_back(face);
      return;
    }
    const PartCorner apex{longest->second.vertex, face.middle(0)};
    for (const std::size_t side : {std::size_t{1}, std::size_t{2}}) {
      const PartCorner &from = face.corner[side], &to = face.next(side);
      const auto cut = cut_.find(face.edge(side));
      if (cut == cut_.end()) {
        out.push_back({face.of, {apex, from, to}});
        continue;
      }
      const PartCorner middle{cut->second.vertex, face.middle(side)};
      out.push_back({face.of, {apex, from, middle}});
      out.push_back({face.of, {apex, middle, to}});
    }
  }

  const SmoothSurface& smooth_;
  std::vector<Vec3> places_;
  std::vector<FacePart> faces_;
  std::map<Edge, EdgeMiddle> cut_;
};

}  // namespace

Surface divided(const SmoothSurface& surface, const IsDivided& is_divided,
                const DivisionLimits& limits) {
  Division division(surface);
  while (division.cut_once(is_divided, limits)) {
  }
  return division.surface();
}

Surface divided_near(const Surface& surface, const Vec3& centre, double radius_m,
                     double longest_m) {
  const auto comes_near = [&](std::int32_t, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 w = nearest_weights(centre, a, b, c);
    return (w[0] * a + w[1] * b + w[2] * c - centre).norm() <= radius_m;
  };
  return divided(SmoothSurface(surface), comes_near, {.longest_m = longest_m});
}

}  // namespace palpate::fem
