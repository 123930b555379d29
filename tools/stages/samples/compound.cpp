#include "tools/stages/samples/experiment_table.hpp"

#include <fmt/core.h>

#include <cmath>

#include "libfem/probes/probes.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/draw.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

constexpr int kSlides = 4;  // directions in which balls are looked for outside the region

// Balls where they are in the tool's own axes.
Points balls_of(const ToolSection& tool) {
  if (tool.row == 0) return tool.balls_m;
  const auto& capsule = tool.probe.rigid->geometry.number;
  const double radius_m = capsule[0], half_m = capsule[1] / 2;
  Points out = Points::Zero(tool.row, 3);
  for (int i = 0; i < tool.row; ++i)
    out(i, 2) = (half_m - radius_m) * (2.0 * i / (tool.row - 1) - 1);
  return out;
}
double radius_of(const Scene& scene, const ToolSection& tool, Eigen::Index ball) {
  if (!tool.radius_m.empty())
    return tool.radius_m[tool.radius_m.size() == 1 ? 0 : static_cast<std::size_t>(ball)];
  if (tool.row > 0) return tool.probe.spec.values.at("radius").front();
  return ball_radius_m(scene.probe.spec);
}

Stance stance_of(const Scene& scene, const ToolSection& tool, const Vec3& inward,
                 const Lean& lean) {
  return fem::stance(fem::tilted(*tool.probe.rigid, inward, lean, tool_place(scene, tool)), inward);
}

class ToolDrawing {
 public:
  ToolDrawing(const Scene& scene, const ToolSection& tool, const Body& body)
      : scene_(scene),
        tool_(tool),
        body_(body),
        balls_m_(balls_of(tool)),
        reach_(make_reach(with_tool(scene, tool), body.surface)),
        boxes_(triangle_boxes(body.surface)) {}

  HeldOut draw(int paths, std::uint64_t seed) const {
    const Experiments& each = scene_.experiments.each;
    HeldOutRange range{each.depth_m, each.drag_distance_m};
    range.tilt_rad = tool_.tilt_rad;
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
  // The tool comes near to the point, and none of its balls leaves the region.
  bool can_stand(const Vec3& position, const Vec3& inward, const Lean& lean) const {
    const Experiments& each = scene_.experiments.each;
    const double overlap_m = reach_.overlap_m(position, inward, lean);
    // By which the tool may touch beside the point.
    if (overlap_m > 0.5 * each.depth_m) return false;
    const Stance stance = stance_of(scene_, tool_, inward, lean);
    const Vec3 down = position + (each.depth_m - overlap_m) * inward;
    const Vec3 across = inward.unitOrthogonal();
    for (int turn = 0; turn <= kSlides; ++turn) {
      const double angle = turn * 2 * std::acos(-1.0) / kSlides;
      const Vec3 slide =
          turn == kSlides ? Vec3(Vec3::Zero())
                          : Vec3(each.drag_distance_m * (std::cos(angle) * across +
                                                         std::sin(angle) * inward.cross(across)));
      for (Eigen::Index i = 0; i < balls_m_.rows(); ++i)
        if (!is_answered(
                down + slide + stance.axes * (balls_m_.row(i).transpose() - stance.touch_m),
                radius_of(scene_, tool_, i)))
          return false;
    }
    return true;
  }

  // A ball in the air is, and one that touches what can be reached.
  bool is_answered(const Vec3& centre, double radius_m) const {
    const auto nearest = closest_point(body_.surface, boxes_, centre);
    if (nearest->distance_m > radius_m && !is_inside(body_.surface, boxes_, centre)) return true;
    const auto corner = body_.surface.triangles.row(nearest->triangle);
    return body_.is_reachable[corner[0]] && body_.is_reachable[corner[1]] &&
           body_.is_reachable[corner[2]];
  }

  const Scene& scene_;
  const ToolSection& tool_;
  const Body& body_;
  Points balls_m_;
  fem::ToolReach reach_;
  BoxTree boxes_;
};

}  // namespace

PlayedTool tool_shape(const Scene& scene, const ToolSection& tool) {
  if (tool.row > 0 && tool.probe.spec.shape != "capsule")
    throw Error(tool_place(scene, tool),
                fmt::format("balls = {} is a row along a capsule", tool.row),
                "Take shape = \"capsule\", or balls as a list of places.");
  PlayedTool out;
  if (tool.has_balls()) {
    const Points balls_m = balls_of(tool);
    out.shape.balls = static_cast<int>(balls_m.rows());
    for (int i = 0; i < out.shape.balls; ++i) {
      Eigen::Map<Vec3>(out.shape.ball[i].centre_m) = balls_m.row(i);
      out.shape.ball[i].radius_m = radius_of(scene, tool, i);
      out.end.push_back(runtime::ball_indenter(out.shape.ball[i].radius_m));
    }
    return out;
  }
  const auto end = tool.probe.rigid ? fem::round_end(*tool.probe.rigid) : std::nullopt;
  if (!end)
    throw Error(tool_place(scene, tool),
                fmt::format("is a {} that is not round along its press", tool.probe.spec.shape),
                "Say what it is played as: balls = 4, or their places, with radii.");
  out.shape.ball[0].radius_m = end->round_end_m;
  out.shape.ball[0].centre_m[2] = end->round_end_m;
  out.end = {*end};
  return out;
}

std::vector<NamedTool> played_tools(const Scene& scene) {
  std::vector<NamedTool> out;
  if (scene.tool) out.push_back({scene.tool->name, tool_shape(scene, *scene.tool)});
  for (const ToolSection& tool : scene.stated) out.push_back({tool.name, tool_shape(scene, tool)});
  return out;
}

std::optional<Indenter> own_end(const Scene& scene) {
  return scene.probe.rigid ? fem::round_end(*scene.probe.rigid) : std::nullopt;
}

Indenter meeting_end(const std::string& scene_path, const runtime::AssetView& asset) {
  const Scene scene = read_scene(scene_path);
  const std::optional<Indenter> end = own_end(scene);
  if (!end)
    throw Error(scene_path + ": [probe]",
                fmt::format("is a {} that is not round along its press", scene.probe.spec.shape),
                "Name a scene with a ball, a cone or a rod.");
  if (!runtime::knows_radius(asset))
    throw Error("--tool", "the asset was measured with no ball, and knows no other tool",
                "Leave --tool out.");
  return *end;
}

Scene with_tool(const Scene& scene, const ToolSection& tool) {
  Scene out = scene;
  out.probe = tool.probe;
  return out;
}

void check_tools(const Scene& scene) {
  std::vector<ToolSection> all = scene.stated;
  if (scene.tool) all.push_back(*scene.tool);
  all.insert(all.end(), scene.pressed.begin(), scene.pressed.end());
  if (all.empty()) return;
  if (scene.probe.spec.shape != "sphere")
    throw Error(tool_place(scene, all.front()),
                fmt::format("is played by what a ball identifies, and [probe] is a {}",
                            scene.probe.spec.shape),
                "Take shape = \"sphere\" in [probe], or leave the tool out.");
  for (const ToolSection& tool : all) {
    tool_shape(scene, tool);
    if (tool.has_balls() && tool.probe.rigid)
      fem::tilted(*tool.probe.rigid, -Vec3::UnitZ(), lean_of(tool.tilt_rad, 0),
                  tool_place(scene, tool) + " tilt");
  }
  for (const ToolSection& tool : scene.pressed)
    if (tool.has_balls())
      throw Error(tool_place(scene, tool), "identifies by its round end, and is played as balls",
                  "Leave balls out of [[experiments.probe]].");
}

HeldOut draw_tool_paths(const Scene& scene, const ToolSection& tool, const Body& body, int paths,
                        std::uint64_t seed) {
  return ToolDrawing(scene, tool, body).draw(paths, seed);
}

double known_depth_m(const Scene& scene, const ToolSection& tool) {
  return runtime::known_depth_m(tool_shape(scene, tool).end.front(),
                                ball_radius_m(scene.probe.spec), scene.experiments.each.depth_m);
}

PlayedTool played_as_tool(const Scene& scene, const ToolSection& tool, ToolShapes& shapes,
                          const Samples& samples, Eigen::Index row) {
  const auto [known, is_new] = shapes.try_emplace(&tool);
  if (is_new) known->second = tool_shape(scene, tool);
  PlayedTool out = known->second;
  if (!tool.has_balls()) {  // upright, its lowest point where the row says: as a tip
    out.shape.ball[0] = {};
    return out;
  }
  const Vec3 inward = samples.point_normal.row(samples.point[row]);
  out.stance = stance_of(scene, tool, inward, samples.lean_at(row));
  return out;
}

}  // namespace palpate::tools
