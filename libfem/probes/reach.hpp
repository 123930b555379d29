#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::fem {

/// Which points of a body at rest a tool can touch: where it can stand with its reference point
/// there, pressed along the inward normal by nothing, without cutting into the body elsewhere by
/// more than a tolerance, and can have come to from outside.
class ToolReach {
 public:
  /// closed: outward [m]. tolerance_m > 0.
  ToolReach(const Surface& closed, Probe probe, double tolerance_m);

  /// Depth [m] by which the tool that first touches at `position` along `inward` (unit) cuts into
  /// the body: the deepest that a point of the body's surface lies in the tool, to a quarter of the
  /// tolerance, by branch and bound over the triangles; or, if that is more, how deep the tool's
  /// middle lies in both. Of a ball this is its radius less the signed distance of its centre. 0
  /// where it cuts nothing. Any shape, exact as its signed distance. lean: of the tool (tilted()).
  double overlap_m(const Vec3& position, const Vec3& inward, const Lean& lean = Lean::Zero()) const;
  bool is_free(const Vec3& position, const Vec3& inward, const Lean& lean = Lean::Zero()) const {
    return overlap_m(position, inward, lean) <= tolerance_m_;
  }

  /// Per vertex, of those that are candidates: 1 where the tool is free and can be reached. Patches
  /// of free vertices can when the ball that presses like the tool leaves one of their places
  /// straight, along the normal or another of 26 directions, or comes straight to a patch that
  /// can; so neither cavities nor chambers with a narrow mouth count. Shapes with a shaft that has
  /// no end need none: where they are free, they could be reached. overlap_m (may be null): per
  /// vertex, 0 of others than candidates.
  /// outward: vertex_normals(closed).
  std::vector<char> vertices(const std::vector<char>& is_candidate, const Points& outward,
                             std::vector<double>* overlap_m = nullptr) const;

 private:
  double overlap_with_triangle_m(const Probe& probe, const Vec3& position, const Vec3& inward,
                                 std::int32_t triangle, double least_m) const;
  double ball_radius_m() const { return std::min(probe_.length_m, probe_.half_width_m); }
  bool passes(Vec3 centre, const Vec3& direction, double length_m) const;
  bool can_leave(const std::vector<Vec3>& centres, const std::vector<Vec3>& outside) const;
  void drop_enclosed(const Points& outward, std::vector<char>& is_reached) const;

  Surface surface_;
  BoxTree boxes_;
  Vec3 low_, high_;
  Probe probe_;
  double tolerance_m_, resolution_m_;
};

}  // namespace palpate::fem
