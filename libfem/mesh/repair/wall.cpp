#include "libfem/mesh/repair/wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {
namespace {

// Nodes of a grid over the body that lie deeper than the wall.
class DeepNodes {
 public:
  DeepNodes(const Surface& outer, double wall_m) : low_(outer.vertices.colwise().minCoeff()) {
    const Vec3 extent = extent_m(outer.vertices);
    // Two nodes to a wall find every lumen that an edge of 0.65 walls can bound; 4 million nodes
    // bound the time on bodies of many walls.
    spacing_m_ = std::max(0.5 * wall_m, std::cbrt(extent.prod() / 4e6));
    for (int k = 0; k < 3; ++k) size_[k] = 2 + static_cast<int>(extent[k] / spacing_m_);
    const BoxTree boxes = triangle_boxes(outer);
    std::vector<char> is_far(size_[0] * size_[1] * size_[2]);
    for (std::size_t node = 0; node < is_far.size(); ++node)
      is_far[node] = !closest_point(outer, boxes, place(node), wall_m);
    // A part that hangs together is inside or outside as a whole. Its deepest node is the last that
    // layers taken off from its rim reach.
    std::vector<char> is_left = is_far;
    for (std::size_t first = 0; first < is_far.size(); ++first) {
      if (!is_left[first]) continue;
      const std::vector<std::size_t> part = flooded(is_left, {first});
      if (is_inside(outer, boxes, place(first)))
        seeds_.push_back(place(by_layers(is_far, part).back()));
    }
  }

  // The deepest node of each part.
  const std::vector<Vec3>& seeds() const { return seeds_; }

 private:
  // Returns `from` and the nodes that hang together with them, the nearest first; is_left loses
  // them.
  std::vector<std::size_t> flooded(std::vector<char>& is_left,
                                   std::vector<std::size_t> from) const {
    for (const std::size_t node : from) is_left[node] = 0;
    for (std::size_t at = 0; at < from.size(); ++at)
      for (const std::size_t next : neighbours(from[at]))
        if (is_left[next]) is_left[next] = 0, from.push_back(next);
    return from;
  }
  // Returns the nodes of a part from its rim inward.
  std::vector<std::size_t> by_layers(std::vector<char> is_left,
                                     const std::vector<std::size_t>& part) const {
    std::vector<std::size_t> rim;
    for (const std::size_t node : part) {
      const auto next = neighbours(node);
      if (next.size() < 6 || std::ranges::any_of(next, [&](auto at) { return !is_left[at]; }))
        rim.push_back(node);
    }
    return flooded(is_left, std::move(rim));
  }
  std::array<std::size_t, 3> index(std::size_t node) const {
    return {node % size_[0], node / size_[0] % size_[1], node / (size_[0] * size_[1])};
  }
  Vec3 place(std::size_t node) const {
    const auto at = index(node);
    return low_ + spacing_m_ * Vec3(at[0], at[1], at[2]);
  }
  std::vector<std::size_t> neighbours(std::size_t node) const {
    const auto at = index(node);
    const std::array<std::size_t, 3> stride{1, size_[0], size_[0] * size_[1]};
    std::vector<std::size_t> out;
    for (int k = 0; k < 3; ++k) {
      if (at[k] > 0) out.push_back(node - stride[k]);
      if (at[k] + 1 < size_[k]) out.push_back(node + stride[k]);
    }
    return out;
  }

  Vec3 low_;
  double spacing_m_ = 0;
  std::array<std::size_t, 3> size_{};
  std::vector<Vec3> seeds_;
};

// Fills thickness_m and solid_share, by the centroids of the outer surface's triangles.
void measure_wall(const Surface& outer, const Surface& lumen, Walled& out) {
  const BoxTree boxes = triangle_boxes(lumen);
  std::vector<double> distance_m, area_m2;
  for (Eigen::Index f = 0; f < outer.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(outer, f);
    area_m2.push_back((b - a).cross(c - a).norm() / 2);
    distance_m.push_back(closest_point(lumen, boxes, (a + b + c) / 3)->distance_m);
  }
  // At a pole of a lumen the wall is as thick as elsewhere; where it is twice that, none is near.
  out.thickness_m = weighted_median(distance_m, area_m2);
  double solid_m2 = 0, all_m2 = 0;
  for (std::size_t f = 0; f < area_m2.size(); ++f) {
    all_m2 += area_m2[f];
    if (distance_m[f] > 2 * out.thickness_m) solid_m2 += area_m2[f];
  }
  out.solid_share = solid_m2 / all_m2;
}

Walled with_lumen_inward(const Surface& outer, Surface lumen) {
  if (volume_m3(lumen) > 0) lumen.triangles.col(0).swap(lumen.triangles.col(1));
  Walled out;
  measure_wall(outer, lumen, out);
  const Eigen::Index n = outer.vertices.rows(), f = outer.triangles.rows();
  out.surface.vertices.resize(n + lumen.vertices.rows(), 3);
  out.surface.vertices << outer.vertices, lumen.vertices;
  out.surface.triangles.resize(f + lumen.triangles.rows(), 3);
  out.surface.triangles << outer.triangles,
      (lumen.triangles.array() + static_cast<std::int32_t>(n)).matrix();
  out.lumens = static_cast<int>(parts_of(lumen).size());
  out.lumen_m3 = -volume_m3(lumen);
  return out;
}

}  // namespace

bool leaves_lumen(const Surface& outer, double wall_m) {
  return !DeepNodes(outer, wall_m).seeds().empty();
}

Walled with_wall(const Surface& outer, double wall_m) {
  if (!(wall_m > 0)) throw Error("wall", "is not positive", "Give the thickness of the wall.");
  const std::vector<Vec3> seeds = DeepNodes(outer, wall_m).seeds();
  if (seeds.empty()) return {outer, 0, 0, 0, 1};
  // Edges of 0.65 walls: a ball of five walls has a lumen 2.5 % too small, 3.3 at 0.75; half a wall
  // takes 1.7 times the time, which is most of what `new` takes of a bowel.
  return with_lumen_inward(outer, repair::wrap_surface(outer, 0.65 * wall_m, wall_m, seeds));
}

Walled with_lumen(const Surface& outer, Surface lumen, const std::string& where) {
  const BoxTree boxes = triangle_boxes(outer);
  for (Eigen::Index v = 0; v < lumen.vertices.rows(); ++v)
    if (!is_inside(outer, boxes, lumen.vertices.row(v)))
      throw Error(where, fmt::format("vertex {} of the lumen lies outside the body", v + 1),
                  "Give the inner surface, in the frame and unit of the body.");
  return with_lumen_inward(outer, std::move(lumen));
}

}  // namespace palpate
