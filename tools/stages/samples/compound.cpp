#include "tools/stages/samples/compound.hpp"

#include <fmt/core.h>

#include <cmath>
#include <memory>

#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/fit/compound.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/paths.hpp"
#include "libfit/validation/tick_time.hpp"
#include "libfit/validation/torque.hpp"
#include "tools/console.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/body/reach.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/kept_paths.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

using validation::HeldOut;

constexpr std::uint64_t kFitSeed = 0x746f6f6c;
constexpr int kSlides = 4;        // directions in which balls are looked for outside the region
constexpr double kLongest = 0.5;  // of the depth, by which the tool may touch beside the point

std::string place_of(const Scene& scene) { return scene.path.string() + ": [tool]"; }

// The scene whose probe is the tool.
Scene with_tool(const Scene& scene) {
  Scene out = scene;
  out.probe = scene.tool->probe;
  return out;
}

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

// What is drawn for the tool: held-out paths and how it stands on each.
struct DrawnTool {
  HeldOut held_out;
  CompoundPaths tool;
};

class ToolDrawing {
 public:
  ToolDrawing(const Scene& scene, const Body& body)
      : scene_(scene),
        body_(body),
        probe_(fem::make_probe(scene.tool->probe.spec, place_of(scene))),
        balls_m_(balls_of(scene, probe_)),
        reach_(make_reach(with_tool(scene), body.surface)),
        boxes_(triangle_boxes(body.surface)) {}

  DrawnTool draw(int paths, std::uint64_t seed) const {
    const Experiments& each = scene_.experiments.each;
    validation::HeldOutRange range{each.depth_m, each.drag_distance_m};
    range.tilt_rad = scene_.tool->tilt_rad;
    range.can_lean = [&](const Vec3& position, const Vec3& inward, const Lean& lean) {
      return can_stand(position, inward, lean);
    };
    DrawnTool out{validation::draw_leaning(body_, range, paths, seed), {}};
    const double radius_m = ball_radius_m(scene_.probe.spec);
    for (std::size_t i = 0; i < out.held_out.paths.size(); ++i) {
      ToolPath& path = out.held_out.paths[i];
      const Vec3 position = out.held_out.points.position.row(path.point),
                 inward = out.held_out.points.normal.row(path.point);
      // Begins where it first touches, which may be beside the point.
      path.deflections.rowwise() -=
          (reach_.overlap_m(position, inward, path.lean) * inward).transpose();
      out.tool.stance.push_back(stance_at(inward, path.lean));
      out.tool.shape.push_back(shape_of(balls_m_, radius_m));
    }
    out.tool.paths = out.held_out.paths;
    return out;
  }

  // The same tool as the ball alone that goes deepest.
  CompoundPaths foremost(const DrawnTool& drawn) const {
    CompoundPaths out = drawn.tool;
    for (std::size_t i = 0; i < out.paths.size(); ++i) {
      const Vec3 inward = drawn.held_out.points.normal.row(out.paths[i].point);
      Eigen::Index deepest = 0;
      (balls_m_ * (out.stance[i].axes.transpose() * inward)).maxCoeff(&deepest);
      out.shape[i] = shape_of(balls_m_.row(deepest), ball_radius_m(scene_.probe.spec));
    }
    return out;
  }

 private:
  Stance stance_at(const Vec3& inward, const Lean& lean) const {
    return fem::stance(fem::tilted(probe_, inward, lean, place_of(scene_)), inward);
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

Samples simulate(const Scene& scene, const Body& body, const HeldOut& drawn, int jobs,
                 const std::filesystem::path& output, const std::string& fingerprint, bool resume) {
  Samples samples = simulate_kept_paths(fem::Simulator(make_setup(with_tool(scene), body)),
                                        drawn.points, drawn.paths,
                                        {.what = "tool",
                                         .jobs = jobs,
                                         .output = output,
                                         .fingerprint = fingerprint,
                                         .resume = resume});
  list_bad_experiments(samples);
  return samples;
}

// Reference and answer of every row, as validation.csv has those of the probe.
void write_rows(const std::filesystem::path& path, const Samples& samples,
                const CompoundForces& by) {
  static constexpr std::string_view kHeader[] = {
      "point", "step", "status", "lean_1", "lean_2", "dx_m",  "dy_m",  "dz_m",  "fx_N",  "fy_N",
      "fz_N",  "ex_N", "ey_N",   "ez_N",   "tx_Nm",  "ty_Nm", "tz_Nm", "ux_Nm", "uy_Nm", "uz_Nm"};
  CsvWriter csv(path, kHeader);
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    csv.text(samples.point_name[static_cast<std::size_t>(samples.point[r])])
        .integer(samples.step[r])
        .text(kRowStatusNames[static_cast<std::size_t>(samples.status[r])]);
    for (int k = 0; k < 2; ++k) csv.number(samples.lean.rows() > 0 ? samples.lean(row, k) : 0);
    for (const Points* three :
         {&samples.deflection, &samples.force, &by.force_N, &samples.torque, &by.torque_Nm})
      for (int k = 0; k < 3; ++k) csv.number((*three)(row, k));
    csv.end_row();
  }
  csv.commit();
}

std::vector<validation::ComparedRow> compared(const Samples& samples, const CompoundForces& by) {
  std::vector<validation::ComparedRow> rows;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[static_cast<std::size_t>(row)] == RowStatus::good)
      rows.push_back({samples.force.row(row), by.force_N.row(row), samples.force_error[row]});
  return rows;
}

validation::NamedTorque torque_error(std::string name, const Samples& samples,
                                     const CompoundForces& by) {
  std::vector<validation::ComparedTorque> rows;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[static_cast<std::size_t>(row)] == RowStatus::good)
      rows.push_back({samples.torque.row(row), by.torque_Nm.row(row)});
  return validation::named_torque(std::move(name), rows, validation::torque_floor_Nm(rows));
}

}  // namespace

runtime::ToolShape tool_shape(const Scene& scene) {
  const fem::Probe probe = fem::make_probe(scene.tool->probe.spec, place_of(scene));
  return shape_of(balls_of(scene, probe), ball_radius_m(scene.probe.spec));
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

Samples simulate_tool(const Scene& scene, const Body& body, int jobs,
                      const std::filesystem::path& output, const std::string& fingerprint,
                      bool resume) {
  const DrawnTool drawn = ToolDrawing(scene, body).draw(scene.tool->paths, kFitSeed);
  return simulate(scene, body, drawn.held_out, jobs, output, fingerprint, resume);
}

CouplingEvidence tool_evidence(const runtime::AssetView& asset, const Scene& scene,
                               const Body& body, const Samples& samples) {
  const auto drawn =
      std::make_shared<DrawnTool>(ToolDrawing(scene, body).draw(scene.tool->paths, kFitSeed));
  const double depth_m = scene.experiments.each.depth_m;
  const auto replayed = [&asset, &samples, drawn, depth_m](const runtime::CouplingView& coupling) {
    return replay_compound(asset, coupling, drawn->tool, samples, depth_m);
  };
  const auto residual = [&samples, drawn, replayed](const runtime::CouplingView& coupling) {
    return compound_residual(drawn->tool, samples, replayed(coupling));
  };
  const auto report = [&samples, replayed](const runtime::CouplingView& coupling) {
    const auto felt = validation::summarize(compared(samples, replayed(coupling))),
               alone = validation::summarize(compared(samples, replayed({})));
    say("  tool: forces of its paths are off by {} (median), {} (p95) if its balls feel each "
        "other, {} and {} if not",
        stated_percent(felt.median_rel), stated_percent(felt.p95_rel),
        stated_percent(alone.median_rel), stated_percent(alone.p95_rel));
  };
  return {residual, report};
}

void state_tool(const std::filesystem::path& path, const Scene& scene, const Body& body, int jobs,
                const std::filesystem::path& folder, bool resume,
                validation::Statement& statement) {
  if (!scene.tool || scene.tool->held_out == 0) return;
  const AssetFile file = read_asset_file(path);
  const ToolDrawing drawing(scene, body);
  const DrawnTool drawn =
      drawing.draw(scene.tool->held_out, static_cast<std::uint64_t>(scene.validate.seed));
  ContentHash hash;
  hash.add(tool_fingerprint(scene, body)).add(std::to_string(scene.validate.seed));
  const Samples samples =
      simulate(scene, body, drawn.held_out, jobs,
               folder.empty() ? folder : folder / "reference_tool.h5", hash.hex(), resume);
  const double depth_m = scene.experiments.each.depth_m;
  const runtime::CouplingView* known = file.asset().coupling;
  const runtime::CouplingView coupling = known != nullptr ? *known : runtime::CouplingView();
  const CompoundForces felt = replay_compound(file.asset(), coupling, drawn.tool, samples, depth_m);
  const auto put = [&](const char* name, const CompoundForces& by) {
    statement.tool.push_back(
        validation::named_error(name, compared(samples, by), statement.floor_N));
    statement.tool_torque.push_back(torque_error(name, samples, by));
  };
  if (!folder.empty()) write_rows(folder / "tool.csv", samples, felt);
  put("felt", felt);
  put("each_by_itself", replay_compound(file.asset(), {}, drawn.tool, samples, depth_m));
  put("foremost_ball",
      replay_compound(file.asset(), {}, drawing.foremost(drawn), samples, depth_m));
  statement.tool_tick_ns = validation::tick_ns(
      [&] { return replay_compound(file.asset(), coupling, drawn.tool, samples, depth_m).ticks; });
}

}  // namespace palpate::tools
