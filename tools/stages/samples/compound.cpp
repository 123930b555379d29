#include "tools/stages/samples/compound.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>

#include "libfem/probes/probes.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/draw.hpp"
#include "tools/stages/body/reach.hpp"

namespace palpate::tools {
namespace {

constexpr int kSlides = 4;        // directions in which balls are looked for outside the region
constexpr double kLongest = 0.5;  // of the depth, by which the tool may touch beside the point

std::string place_of(const Scene& scene) { return scene.path.string() + ": [tool]"; }

// Balls where they are in the tool's own axes.
Points balls_of(const Scene& scene, const fem::Probe& probe) {
  const ToolSection& tool = *scene.tool;
  if (tool.row == 0) return tool.balls_m;
  const double radius_m = probe.geometry.number[0], half_m = probe.geometry.number[1] / 2;
  Points out = Points::Zero(tool.row, 3);
  for (int i = 0; i < tool.row; ++i)
    out(i, 2) = (half_m - radius_m) * (2.0 * i / (tool.row - 1) - 1);
  return out;
}

runtime::ToolShape shape_of(const Points& balls_m, double radius_m) {
  runtime::ToolShape out;
  out.balls = static_cast<int>(balls_m.rows());
  for (int i = 0; i < out.balls; ++i) {
    Eigen::Map<Vec3>(out.ball[i].centre_m) = balls_m.row(i);
    out.ball[i].radius_m = radius_m;
  }
  return out;
}

Stance stance_of(const Scene& scene, const fem::Probe& probe, const Vec3& inward,
                 const Lean& lean) {
  return fem::stance(fem::tilted(probe, inward, lean, place_of(scene)), inward);
}

class ToolDrawing {
 public:
  ToolDrawing(const Scene& scene, const Body& body)
      : scene_(scene),
        body_(body),
        probe_(fem::make_probe(scene.tool->probe.spec, place_of(scene))),
        balls_m_(balls_of(scene, probe_)),
        reach_(make_reach(with_tool(scene), body.surface)),
        boxes_(triangle_boxes(body.surface)) {}

  HeldOut draw(int paths, std::uint64_t seed) const {
    const Experiments& each = scene_.experiments.each;
    HeldOutRange range{each.depth_m, each.drag_distance_m};
    range.tilt_rad = scene_.tool->tilt_rad;
    range.can_lean = [&](const Vec3& position, const Vec3& inward, const Lean& lean) {
      return can_stand(position, inward, lean);
    };
    HeldOut out = draw_leaning(body_, range, paths, seed);
    for (ToolPath& path : out.paths) {
      const Vec3 position = out.points.position.row(path.point),
                 inward = out.points.normal.row(path.point);
      // Begins where it first touches, which may be beside the point.
      path.deflections.rowwise() -=
          (reach_.overlap_m(position, inward, path.lean) * inward).transpose();
    }
    return out;
  }

 private:
  Stance stance_at(const Vec3& inward, const Lean& lean) const {
    return stance_of(scene_, probe_, inward, lean);
  }

  // The tool comes near to the point, and none of its balls leaves the region.
  bool can_stand(const Vec3& position, const Vec3& inward, const Lean& lean) const {
    const Experiments& each = scene_.experiments.each;
    const double overlap_m = reach_.overlap_m(position, inward, lean);
    if (overlap_m > kLongest * each.depth_m) return false;
    const Stance stance = stance_at(inward, lean);
    const Vec3 down = position + (each.depth_m - overlap_m) * inward;
    const Vec3 across = inward.unitOrthogonal();
    for (int turn = 0; turn <= kSlides; ++turn) {
      const double angle = turn * 2 * std::acos(-1.0) / kSlides;
      const Vec3 slide =
          turn == kSlides ? Vec3(Vec3::Zero())
                          : Vec3(each.drag_distance_m * (std::cos(angle) * across +
                                                         std::sin(angle) * inward.cross(across)));
      for (Eigen::Index i = 0; i < balls_m_.rows(); ++i)
        if (!is_answered(down + slide +
                         stance.axes * (balls_m_.row(i).transpose() - stance.touch_m)))
          return false;
    }
    return true;
  }

  // A ball in the air is, and one that touches what can be reached.
  bool is_answered(const Vec3& centre) const {
    const auto nearest = closest_point(body_.surface, boxes_, centre);
    if (nearest->distance_m > ball_radius_m(scene_.probe.spec) &&
        !is_inside(body_.surface, boxes_, centre))
      return true;
    const auto corner = body_.surface.triangles.row(nearest->triangle);
    return body_.is_reachable[corner[0]] && body_.is_reachable[corner[1]] &&
           body_.is_reachable[corner[2]];
  }

  const Scene& scene_;
  const Body& body_;
  fem::Probe probe_;
  Points balls_m_;
  fem::ToolReach reach_;
  BoxTree boxes_;
};

}  // namespace

runtime::ToolShape tool_shape(const Scene& scene) {
  const fem::Probe probe = fem::make_probe(scene.tool->probe.spec, place_of(scene));
  return shape_of(balls_of(scene, probe), ball_radius_m(scene.probe.spec));
}

Scene with_tool(const Scene& scene) {
  Scene out = scene;
  out.probe = scene.tool->probe;
  return out;
}

void check_tool(const Scene& scene) {
  if (!scene.tool) return;
  const std::string where = place_of(scene);
  if (scene.probe.spec.shape != "sphere")
    throw Error(where,
                fmt::format("is played as balls, and [probe] is a {}", scene.probe.spec.shape),
                "Take shape = \"sphere\" in [probe], or leave [tool] out.");
  const fem::Probe probe = fem::make_probe(scene.tool->probe.spec, where);
  const double radius_m = ball_radius_m(scene.probe.spec);
  if (scene.tool->row > 0 && (scene.tool->probe.spec.shape != "capsule" ||
                              std::abs(probe.geometry.number[0] - radius_m) > 1e-9 * radius_m))
    throw Error(where,
                fmt::format("balls = {} is a row along a capsule of the probe's radius, {} mm",
                            scene.tool->row, 1e3 * radius_m),
                "Give [probe] the capsule's radius, or balls as a list of places.");
  fem::tilted(probe, -Vec3::UnitZ(), lean_of(scene.tool->tilt_rad, 0), where + " tilt");
}

HeldOut draw_tool_paths(const Scene& scene, const Body& body, int paths, std::uint64_t seed) {
  return ToolDrawing(scene, body).draw(paths, seed);
}

PlayedTool tool_played_as(const Scene& scene, const Samples& samples, Eigen::Index row) {
  const fem::Probe probe = fem::make_probe(scene.tool->probe.spec, place_of(scene));
  const Vec3 inward = samples.point_normal.row(samples.point[static_cast<std::size_t>(row)]);
  const Lean lean = samples.lean.rows() > 0 ? Lean(samples.lean.row(row)) : Lean(Lean::Zero());
  return {shape_of(balls_of(scene, probe), ball_radius_m(scene.probe.spec)),
          stance_of(scene, probe, inward, lean)};
}

PlayedTool foremost_played_as(const Scene& scene, const Samples& samples, Eigen::Index row) {
  PlayedTool out = tool_played_as(scene, samples, row);
  const Vec3 inward = samples.point_normal.row(samples.point[static_cast<std::size_t>(row)]);
  int deepest = 0;
  double most_m = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < out.shape.balls; ++i) {
    const double depth_m =
        Vec3::Map(out.shape.ball[i].centre_m).dot(out.stance.axes.transpose() * inward);
    if (depth_m > most_m) deepest = i, most_m = depth_m;
  }
  out.shape.ball[0] = out.shape.ball[deepest];
  out.shape.balls = 1;
  return out;
}

}  // namespace palpate::tools
