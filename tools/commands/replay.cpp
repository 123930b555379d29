#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/runtime/engine.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/realtime/clock.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

static_assert(kMaxPathTools == runtime::kMaxContacts, "one bound");

/// Forces on one tool at one time.
struct PlayedRow {
  runtime::Status status = runtime::Status::ok;
  ForceRow row;
  std::int64_t guarded = 0;
};

PlayedRow played_row(double time_s, int tool, runtime::Status status,
                     const runtime::ToolOutput& out) {
  PlayedRow played{status, {}, out.refused_ticks};
  ForceRow& row = played.row;
  row.time_s = time_s;
  row.force_N = Vec3(out.force_on_tool_N[0], out.force_on_tool_N[1], out.force_on_tool_N[2]);
  row.is_in_contact = out.state != runtime::ContactState::air;
  row.contact_point_m = Vec3(out.contact_m[0], out.contact_m[1], out.contact_m[2]);
  row.triangle = out.triangle;
  row.depth_m = out.normal_m;
  row.lateral_m = out.lateral_m;
  row.is_sliding = out.state == runtime::ContactState::slip;
  row.is_outside = (out.flags & PALPATE_FLAG_OUTSIDE) != 0;
  row.is_extrapolated = (out.flags & PALPATE_FLAG_EXTRAPOLATED) != 0;
  row.is_blocked = (out.flags & PALPATE_FLAG_BLOCKED) != 0;
  row.is_in_debt = (out.flags & PALPATE_FLAG_HELD_BACK) != 0;
  row.tool = tool;
  row.torque_Nm = Vec3::Map(out.torque_on_tool_Nm);
  return played;
}

runtime::Pose pose_at(const PosePath& path, std::size_t row) {
  runtime::Pose pose;
  const auto r = static_cast<Eigen::Index>(row);
  for (int k = 0; k < 3; ++k) pose.position_m[k] = path.position(r, k);
  if (path.orientation.rows() > 0)
    for (int k = 0; k < 4; ++k) pose.orientation[k] = path.orientation(r, (k + 3) % 4);
  return pose;
}

// The ticks of a path: as fast as possible, or by a clock.
class Ticks {
 public:
  Ticks(const PosePath& path, double rate_Hz) : path_(path) {
    if (rate_Hz != 0) clock_.emplace(rate_Hz, path.time_s.size());
  }
  /// Begins tick i, once it is due; returns the time since the one before it [s].
  double begin(std::size_t i) {
    if (is_interrupted()) throw Interrupted("replay: nothing was written");
    if (!clock_) return i > 0 ? path_.time_s[i] - path_.time_s[i - 1] : runtime::kCheckTick_s;
    clock_->wait();
    return clock_->period_s();
  }
  void end() {
    if (clock_) clock_->done();
  }
  std::vector<std::string> report() const {
    return clock_ ? clock_->report() : std::vector<std::string>();
  }

 private:
  const PosePath& path_;
  std::optional<RealtimeClock> clock_;
};

// The tools. A path without a scene is of tips.
class ToolSet {
 public:
  /// scenes: one for all tools, or one each.
  ToolSet(const std::string& scenes, int tools) : tool_(static_cast<std::size_t>(tools)) {
    if (scenes.empty()) return;
    std::vector<PlayedTool> shape;
    for (const std::string& scene : parts_of_list(scenes))
      shape.push_back(shape_of(read_scene(scene)));
    if (shape.size() != 1 && shape.size() != tool_.size())
      throw Error("--tool", fmt::format("names {} scenes for {} tools", shape.size(), tool_.size()),
                  "Name one for all tools of the path, or one for each.");
    for (std::size_t k = 0; k < tool_.size(); ++k) {
      const PlayedTool& played = shape[shape.size() == 1 ? 0 : k];
      tool_[k].shape = played.shape;
      end_.push_back(played.end);
    }
  }

  int balls() const {
    int balls = 0;
    for (const runtime::Tool& tool : tool_) balls += tool.shape.balls;
    return balls;
  }
  std::vector<runtime::Tool>& tools() { return tool_; }

  /// Tabulates how their ends meet the asset.
  void meet(IndenterAssets& met) {
    for (std::size_t k = 0; k < end_.size(); ++k) met.put_into(end_[k], tool_[k].shape);
  }

  void check(const runtime::AssetView& asset) const {
    if (balls() > runtime::kMaxContacts)
      throw Error("--tool", fmt::format("the path's tools have {} balls between them", balls()),
                  fmt::format("The engine takes {}.", runtime::kMaxContacts));
    const bool is_row = std::any_of(tool_.begin(), tool_.end(),
                                    [](const runtime::Tool& tool) { return tool.shape.balls > 1; });
    if (is_row && asset.coupling == nullptr)
      throw Error(
          "--tool",
          "it is played as several balls, and contacts of this asset feel nothing of each other",
          "Make the asset by `palpate run` of a scene with [tool], or with pairs.");
  }

  /// The centres of all balls along a path, and a radius each.
  struct Places {
    Points centre_m;
    std::vector<double> radius_m;
    std::size_t of_a_time = 1;
  };
  Places along(const PosePath& path) const {
    Places out{Points(static_cast<Eigen::Index>(path.time_s.size()) * balls(), 3),
               {},
               static_cast<std::size_t>(balls())};
    Eigen::Index at = 0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(path.position.rows()); ++row) {
      const runtime::ToolShape& shape = tool_[row % tool_.size()].shape;
      runtime::Frame frame = {};
      make_frame(pose_at(path, row), frame);
      for (int i = 0; i < shape.balls; ++i) {
        const runtime::Vec3d centre =
            frame.place(runtime::make_vec3<double>(shape.ball[i].centre_m));
        out.centre_m.row(at++) << centre.x, centre.y, centre.z;
        out.radius_m.push_back(shape.ball[i].radius_m);
      }
    }
    return out;
  }

 private:
  // [tool] as it is played; else the round end of [probe], whose lowest point takes the path.
  static PlayedTool shape_of(const Scene& scene) {
    if (scene.tool) return tool_shape(scene, *scene.tool);
    ToolSection probe;
    probe.name = "[probe]";
    probe.probe = scene.probe;
    return tool_shape(scene, probe);
  }

  std::vector<runtime::Tool> tool_;
  std::vector<std::vector<Indenter>> end_;  ///< of each
};

// Where a path stands to the surface that answers: what a user must know of forces that are zero.
class PathOnBody {
 public:
  PathOnBody(const runtime::AssetView& asset, ToolSet::Places places, const std::string& file)
      : asset_(asset),
        places_(std::move(places)),
        body_(palpate::surface_of(asset)),
        boxes_(triangle_boxes(body_)) {
    const Vec3 extent = extent_m(body_.vertices);
    for (const double radius_m : places_.radius_m)
      if (const auto unit = misread_unit(radius_m, extent))
        throw Error(
            "--tool",
            fmt::format("its ball has a radius of {:.4g} m, and the body measures {}", radius_m,
                        size_in_words(extent, 0)),
            fmt::format("Numbers without a unit are metres: write \"{:.4g} {}\" if that is meant.",
                        radius_m, *unit));
    if (const auto unit = misread_unit(places_.centre_m, body_))
      throw Error(file,
                  fmt::format("its columns are in metres, and so it passes the body {:.3g} m away; "
                              "in {} it would lie at the body",
                              nearest_m(), *unit),
                  fmt::format("Write x_m, y_m and z_m in metres: they look like {}.", *unit));
  }

  void say_begin() const {
    for (std::size_t i = 0; i < places_.of_a_time; ++i) {
      const Vec3 at = places_.centre_m.row(i);
      const auto near = closest_point(body_, boxes_, at);
      if (!near) continue;
      const double depth_m =
          places_.radius_m[i] + (is_in_body(at, *near) ? near->distance_m : -near->distance_m);
      if (depth_m <= 1e-6 * extent_m(body_.vertices).norm()) continue;
      warn(
          "the path begins {:.3g} mm inside the body, where there is no force until the tool has "
          "come out and touches from outside: begin outside",
          1e3 * depth_m);
      return;
    }
  }
  void say_leaning() const {
    Vec3 inward = Vec3::Zero();
    for (int v = 0; v < asset_.vertices; ++v)
      if (asset_.covered[v] == runtime::kMeasured)
        inward += Vec3(asset_.normal_at(v).x, asset_.normal_at(v).y, asset_.normal_at(v).z);
    const double lean_deg = std::acos(-inward.normalized().z()) * 180 / std::numbers::pi;
    if (lean_deg > 30)  // where a ball's lowest point is a radius aside by half of itself
      warn(
          "the path has no qx,qy,qz,qw, so the tool stands along z, {:.0f} degrees off the "
          "window's "
          "normal: give its orientation, as the path of `palpate new --path` does",
          lean_deg);
  }
  void say_untouched() const {
    warn(
        "the path never touches the body from outside, so all forces are zero: its nearest row is "
        "{:.3g} mm from surface that answers",
        1e3 * nearest_m());
  }

 private:
  bool is_in_body(const Vec3& tip, const SurfacePoint& near) const {
    const bool is_closed = std::none_of(asset_.neighbour, asset_.neighbour + 3 * asset_.triangles,
                                        [](int other) { return other < 0; });
    if (is_closed) return is_inside(body_, boxes_, tip);
    const auto corner = body_.triangles.row(near.triangle);
    const Vec3 a = body_.vertices.row(corner[0]), b = body_.vertices.row(corner[1]),
               c = body_.vertices.row(corner[2]);
    return (tip - near.position).dot((b - a).cross(c - a)) < 0;
  }
  double nearest_m() const {
    double least_m = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < places_.centre_m.rows(); ++i) {
      const double radius_m = places_.radius_m[i];
      const auto near =
          closest_point(body_, boxes_, places_.centre_m.row(i), least_m + radius_m,
                        [&](const SurfacePoint& p) { return asset_.is_solid(p.triangle); });
      if (near) least_m = std::min(least_m, std::max(near->distance_m - radius_m, 0.0));
    }
    return least_m;
  }

  const runtime::AssetView& asset_;
  ToolSet::Places places_;
  Surface body_;
  BoxTree boxes_;
};

// All tools at each time.
std::vector<PlayedRow> play_tools(const runtime::AssetView& asset, const PosePath& path,
                                  std::vector<runtime::Tool>& tool, Ticks& ticks) {
  const std::size_t tools = tool.size();
  std::vector<runtime::Tool*> all;
  for (runtime::Tool& each : tool) all.push_back(&each);
  std::vector<runtime::ToolInput> in(tools);
  std::vector<runtime::ToolOutput> out(tools);
  std::vector<runtime::Status> status(tools);
  std::vector<PlayedRow> rows_played;
  rows_played.reserve(path.time_s.size() * tools);
  for (std::size_t i = 0; i < path.time_s.size(); ++i) {
    const double dt_s = ticks.begin(i);
    for (std::size_t k = 0; k < tools; ++k) {
      in[k].pose = pose_at(path, i * tools + k);
      in[k].dt_s = dt_s;
    }
    runtime::touch_tools(asset, all.data(), in.data(), out.data(), status.data(),
                         static_cast<int>(tools));
    ticks.end();
    for (std::size_t k = 0; k < tools; ++k)
      rows_played.push_back(played_row(path.time_s[i], static_cast<int>(k), status[k], out[k]));
  }
  return rows_played;
}

class Replay final : public Command {
 public:
  explicit Replay(Arguments& arguments) {
    arguments.positional("asset", asset_, "Asset to play, asset.palp");
    arguments.positional(
        "path", path_,
        "Path of the tools in seconds and metres, PATH.csv: t_s,x_m,y_m,z_m[,qx,qy,qz,qw][,tool]");
    arguments.output("-o,--output", output_,
                     "FORCES.csv to write, with forces on the tool in newtons", {"t_s,fx_N"});
    arguments.option("--tool", tool_,
                     "Scene whose [tool], or the round end of its [probe], takes the path in place "
                     "of a tip; of several tools one scene each, with commas");
    arguments.option(
        "--realtime HZ", rate_Hz_,
        "Rate in Hz at which rows are played on the real-time clock; 0 plays as fast as "
        "possible");
  }

  int run(Reply& reply) override {
    const AssetFile file = read_asset_file(asset_);
    const PosePath path = read_pose_path(path_);
    warn_of_unused(path_, path.ignored);
    if (!path.force_N.empty()) warn_of_unused(path_, {"force_N"});
    ToolSet tools(tool_, path.tools);
    tools.check(file.asset());
    IndenterAssets met(file.asset());
    tools.meet(met);
    const PathOnBody on_body(file.asset(), tools.along(path), path_);
    const std::vector<PlayedRow> rows_played = play(file.asset(), path, tools);
    std::vector<ForceRow> rows;
    std::size_t faults = 0, touching = 0, beyond = 0;
    for (const PlayedRow& each : rows_played) {
      if (each.status != runtime::Status::ok && ++faults <= 10) say_fault(each, rows, path);
      rows.push_back(each.row);
      touching += each.row.is_in_contact;
      beyond += each.row.is_extrapolated;
    }
    on_body.say_begin();
    if (!tool_.empty() && path.orientation.rows() == 0) on_body.say_leaning();
    if (touching == 0) on_body.say_untouched();
    if (beyond > 0)
      warn("{} of {} ticks in contact go beyond the curves, and their forces are extrapolated",
           beyond, touching);
    write_forces(output_, rows);
    const std::int64_t guarded = rows_played.empty() ? 0 : rows_played.back().guarded;
    say("wrote {}: {} ticks, {} in contact, {} with a fault, {} where the guard acted", output_,
        rows.size(), touching, faults, guarded);
    reply.json = nlohmann::ordered_json{
        {"ticks", rows.size()}, {"in_contact", touching}, {"faults", faults}, {"guarded", guarded}};
    return faults ? kSomeFailed : kDone;
  }

 private:
  void say_fault(const PlayedRow& played, const std::vector<ForceRow>& before,
                 const PosePath& path) const {
    const std::size_t tick = before.size() / static_cast<std::size_t>(path.tools) + 1;
    say_failed("{}: tick {} at {} s{}: {}", path_, tick, played.row.time_s,
               path.tools > 1 ? fmt::format(", tool {}", played.row.tool) : "",
               runtime::sentence(played.status));
  }
  std::vector<PlayedRow> play(const runtime::AssetView& asset, const PosePath& path,
                              ToolSet& tools) const {
    Ticks ticks(path, rate_Hz_);
    std::vector<PlayedRow> rows_played = play_tools(asset, path, tools.tools(), ticks);
    for (const std::string& line : ticks.report()) say("{}", line);
    return rows_played;
  }

  std::string asset_, path_, output_, tool_;
  int rate_Hz_ = 0;
};

}  // namespace

const CommandRow kReplayCommand{"replay", "Play a tool path on an asset and write the forces",
                                declared<Replay>, "Assets and files",
                                "replay asset.palp path.csv -o forces.csv"};

}  // namespace palpate::tools
