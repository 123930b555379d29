#include "tools/stages/samples/experiment_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/draw.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

const ToolSection* own_probe(const Scene&, Purpose, std::int32_t) { return nullptr; }
const ToolSection* scene_tool(const Scene& scene, Purpose, std::int32_t) { return &*scene.tool; }
const ToolSection* other_tool(const Scene& scene, Purpose purpose, std::int32_t number) {
  return &other_tools(scene, purpose)[number - 1];
}
Scene simulated_with(const Scene& scene, const ToolSection* tool) {
  return tool == nullptr ? scene : with_tool(scene, *tool);
}

// Draws places where the scene's tool can touch, upright and as it leans.
class Reachable {
 public:
  Reachable(const Drawing& drawing)
      : reach_(make_reach(drawing.scene, drawing.body.surface)), scene_(drawing.scene) {}
  HeldOutRange range(double tilt_rad = 0) const {
    const Experiments& each = scene_.experiments.each;
    return {each.depth_m, each.drag_distance_m,
            [this](const Vec3& at, const Vec3& inward) { return reach_.is_free(at, inward); },
            tilt_rad,
            [this](const Vec3& at, const Vec3& inward, const Lean& lean) {
              return reach_.is_free(at, inward, lean);
            }};
  }

 private:
  fem::ToolReach reach_;
  const Scene& scene_;
};

// Presses at every second point that is held out, which tell what an error is made of.
int presses(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::hold_out ? scene.validate.presses() : 0;
}
ExperimentList draw_presses(const Drawing& drawing) {
  const bool is_dragged = !experiments_of(drawing.scene).drag_depths_m.empty();
  std::vector<std::size_t> which(presses(drawing.scene, drawing.purpose));
  for (std::size_t i = 0; i < which.size(); ++i) which[i] = 2 * i;
  return taken(
      experiments_at(drawing.points,
                     std::vector<Effort>(static_cast<std::size_t>(drawing.points.position.rows()),
                                         {is_dragged, 0})),
      which);
}

// On a body that relaxes each path has one of the speeds; on a body that softens each begins with a
// press at its own place.
void put_in_time(const Scene& scene, HeldOut& out) {
  for (std::size_t i = 0; i < out.paths.size(); ++i) {
    ToolPath& path = out.paths[i];
    const std::vector<double>& speeds = scene.validate.speeds_m_s;
    if (relaxes(scene)) path = fem::in_time(path, speeds[i % speeds.size()], scene.validate.hold_s);
    if (!softens(scene)) continue;
    const double turn = (std::numbers::phi - 1) * static_cast<double>(i + 1);
    path =
        fem::after_press(path, out.points.normal.row(path.point),
                         scene.experiments.each.depth_m * (0.5 + 0.5 * (turn - std::floor(turn))));
  }
}

int paths(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::hold_out ? scene.validate.points : 0;
}
ExperimentList draw_paths(const Drawing& drawing) {
  const HeldOut out = draw_held_out_paths(drawing);
  return paths_at(out.points, out.paths);
}

// A third as many as held-out paths: a section's p95 needs three or four places, and slides cost
// half as much again as a mean path.
int changes(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::hold_out ? scene.validate.points / 3 : 0;
}
ExperimentList draw_changes(const Drawing& drawing) {
  const Reachable reachable(drawing);
  HeldOutRange range = reachable.range();
  range.change = drawing.change;
  HeldOut out = draw_sliding(drawing.body, range, changes(drawing.scene, drawing.purpose),
                             drawing.seed(0) ^ 0x6368);
  put_in_time(drawing.scene, out);
  return paths_at(out.points, out.paths);
}

int cycles(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::identify && softens(scene) ? scene.experiments.cycles : 0;
}
ExperimentList draw_cycles(const Drawing& drawing) {
  const Eigen::Index points = drawing.points.position.rows(),
                     count = std::min<Eigen::Index>(points, drawing.scene.experiments.cycles);
  std::vector<ToolPath> paths;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index p = i * points / count;
    paths.push_back(fem::cycled_press(static_cast<int>(p), drawing.points.normal.row(p),
                                      drawing.scene.experiments.each.depth_m));
  }
  return paths_at(drawing.points, paths, ExperimentKind::cycle);
}

int pairs(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::identify ? scene.experiments.pairs : scene.validate.pairs;
}
// The tool that presses in pairs: to identify, the narrowest ball, which comes nearest to another
// one; null: the probe.
const ToolSection* pair_tool(const Scene& scene, Purpose purpose, std::int32_t) {
  const ToolSection* narrowest = nullptr;
  if (purpose == Purpose::hold_out) return narrowest;
  double radius_m = ball_radius_m(scene.probe.spec);
  for (const ToolSection& tool : scene.pressed) {
    if (tool.probe.spec.shape != "sphere" || ball_radius_m(tool.probe.spec) >= radius_m) continue;
    radius_m = ball_radius_m(tool.probe.spec);
    narrowest = &tool;
  }
  return narrowest;
}
ExperimentList draw_pairs(const Drawing& drawing) {
  const ToolSection* tool = pair_tool(drawing.scene, drawing.purpose, 0);
  const Scene scene = simulated_with(drawing.scene, tool);
  const Reachable reachable({scene, drawing.body, drawing.points, drawing.purpose});
  HeldOutRange range = reachable.range();
  if (tool != nullptr) range.depth_m = known_depth_m(drawing.scene, *tool);
  // From side by side to where tools of the probe's radius hardly interact.
  const HeldOut out = draw_two_tools(drawing.body, range, pairs(drawing.scene, drawing.purpose),
                                     2.1 * ball_radius_m(scene.probe.spec),
                                     7 * ball_radius_m(drawing.scene.probe.spec),
                                     drawing.purpose == Purpose::hold_out, drawing.seed(0x7077));
  return paths_at(out.points, out.paths, ExperimentKind::pair);
}
int tools(const Scene& scene, Purpose purpose) {
  if (!scene.tool) return 0;
  return purpose == Purpose::identify ? scene.tool->paths : scene.tool->held_out;
}
ExperimentList draw_tools(const Drawing& drawing) {
  const HeldOut out =
      draw_tool_paths(drawing.scene, *drawing.scene.tool, drawing.body,
                      tools(drawing.scene, drawing.purpose), drawing.seed(0x746f6f6c));
  return paths_at(out.points, out.paths, ExperimentKind::tool);
}

// As deep as the probe, or as it is known for.
std::vector<ToolPath> presses_of(const Drawing& drawing, const ToolSection& tool) {
  const int steps = drawing.scene.experiments.each.press_steps;
  const double depth_m = known_depth_m(drawing.scene, tool);
  const Eigen::Index points = drawing.points.position.rows(),
                     count = std::min<Eigen::Index>(points, tool.paths);
  std::vector<ToolPath> out;
  for (Eigen::Index i = 0; i < count; ++i) {
    ToolPath& path = out.emplace_back();
    path.point = static_cast<int>(i * points / count);
    const Vec3 inward = drawing.points.normal.row(path.point);
    path.deflections.resize(steps, 3);
    for (int step = 0; step < steps; ++step)
      path.deflections.row(step) = ((step + 1) * depth_m / steps) * inward;
  }
  return out;
}

// Paths of each kind, or, of a tool that is played as balls, on which it leans.
HeldOut draw_stated(const Drawing& drawing, const ToolSection& tool) {
  const std::uint64_t seed = drawing.seed(0) ^ 0x73746174;
  if (tool.has_balls())
    return draw_tool_paths(drawing.scene, tool, drawing.body, tool.held_out, seed);
  const Scene scene = with_tool(drawing.scene, tool);
  const Reachable reachable({scene, drawing.body, drawing.points, drawing.purpose});
  HeldOutRange range = reachable.range();
  range.depth_m = known_depth_m(drawing.scene, tool);
  return draw_held_out(drawing.body, range, tool.held_out, seed);
}

int others(const Scene& scene, Purpose purpose) {
  const auto of_which = purpose == Purpose::identify ? &ToolSection::paths : &ToolSection::held_out;
  int count = 0;
  for (const ToolSection& tool : other_tools(scene, purpose)) count += tool.*of_which;
  return count;
}
// To identify, presses in slow motion at test points, spread over them; held out, paths of each
// kind, at places of their own.
ExperimentList draw_others(const Drawing& drawing) {
  const auto& tools = other_tools(drawing.scene, drawing.purpose);
  ExperimentList out;
  out.places.position.resize(0, 3);
  out.places.normal.resize(0, 3);
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const auto number = static_cast<std::int32_t>(i + 1);
    if (drawing.purpose == Purpose::identify) {
      append(out, paths_at(drawing.points, presses_of(drawing, tools[i]), ExperimentKind::other,
                           number));
      continue;
    }
    const HeldOut held_out = draw_stated(drawing, tools[i]);
    append(out, paths_at(held_out.points, held_out.paths, ExperimentKind::other, number));
  }
  return out;
}
// The tool that rows of a kind are of; null: the probe.
const ToolSection* tool_of(const Scene& scene, Purpose purpose, ExperimentKind kind,
                           std::int32_t number) {
  const auto row = std::ranges::find(kExperimentRows, kind, &ExperimentRow::kind);
  return row == kExperimentRows.end() ? nullptr : row->tool(scene, purpose, number);
}

}  // namespace

HeldOut draw_held_out_paths(const Drawing& drawing) {
  const Reachable reachable(drawing);
  HeldOut out = draw_held_out(drawing.body, reachable.range(drawing.scene.validate.tilt_rad),
                              drawing.scene.validate.points, drawing.seed(0));
  put_in_time(drawing.scene, out);
  return out;
}

const std::vector<ExperimentRow> kExperimentRows{
    {ExperimentKind::path, own_probe, paths, draw_paths},
    {ExperimentKind::press, own_probe, presses, draw_presses},
    {ExperimentKind::path, own_probe, changes, draw_changes},
    {ExperimentKind::cycle, own_probe, cycles, draw_cycles},
    {ExperimentKind::pair, pair_tool, pairs, draw_pairs},
    {ExperimentKind::tool, scene_tool, tools, draw_tools},
    {ExperimentKind::other, other_tool, others, draw_others},
};

void check_pairs(const Scene& scene) {
  if (scene.experiments.pairs == 0 && scene.validate.pairs == 0) return;
  if (scene.probe.spec.shape != "sphere")
    throw Error(
        scene.path.string() + ": pairs",
        fmt::format("two tools are simulated as balls, and this is a {}", scene.probe.spec.shape),
        "Take shape = \"sphere\" in [probe], or leave pairs out.");
}

ExperimentList draw_experiments(const Drawing& drawing) {
  ExperimentList out;
  out.places.position.resize(0, 3);
  out.places.normal.resize(0, 3);
  out.places.triangles.resize(0, 3);
  for (const ExperimentRow& row : kExperimentRows)
    if (row.count(drawing.scene, drawing.purpose) > 0) append(out, row.draw(drawing));
  return out;
}

const std::vector<ToolSection>& other_tools(const Scene& scene, Purpose purpose) {
  return purpose == Purpose::identify ? scene.pressed : scene.stated;
}

PlayedAs played_as(const Scene& scene, Purpose purpose, const Samples& samples) {
  auto shapes = std::make_shared<ToolShapes>();
  return [&scene, purpose, &samples, shapes](Eigen::Index row) {
    const ToolSection* tool = tool_of(scene, purpose, samples.kind[row], samples.probe_of(row));
    return tool == nullptr ? PlayedTool() : played_as_tool(scene, *tool, *shapes, samples, row);
  };
}

const fem::Simulator& Simulators::operator()(const Experiment& one) const {
  const ExperimentKind kind = one.kind;
  std::unique_ptr<fem::Simulator>& made = made_[{kind, one.probe_number}];
  if (made) return *made;
  Scene scene = simulated_with(scene_, tool_of(scene_, purpose_, kind, one.probe_number));
  const bool is_kept =
      kind == (purpose_ == Purpose::identify ? ExperimentKind::press : ExperimentKind::path);
  if (const double own = scene_.validate.force_tolerance;
      is_kept && purpose_ == Purpose::hold_out && own > 0)
    scene.experiments.force_tolerance = own;
  made = std::make_unique<fem::Simulator>(is_kept ? make_simulator(scene, body_)
                                                  : fem::Simulator(make_setup(scene, body_)));
  return *made;
}

}  // namespace palpate::tools
