#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/misread_unit.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/vtu.hpp"
#include "libfit/runtime/engine.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/realtime/play.hpp"

namespace palpate::tools {
namespace {

ForceRow to_row(double time_s, const runtime::Output& out) {
  ForceRow row;
  row.time_s = time_s;
  row.force_N = Vec3(out.force_on_tool_N[0], out.force_on_tool_N[1], out.force_on_tool_N[2]);
  row.is_in_contact = out.state != runtime::ContactState::air;
  row.contact_point_m = Vec3(out.contact_m[0], out.contact_m[1], out.contact_m[2]);
  row.triangle = out.triangle;
  row.depth_m = out.normal_m;
  row.lateral_m = out.lateral_m;
  row.is_sliding = out.state == runtime::ContactState::slip;
  row.is_outside = (out.flags & runtime::kFlagOutside) != 0;
  row.is_extrapolated = (out.flags & runtime::kFlagExtrapolated) != 0;
  row.is_blocked = (out.flags & runtime::kFlagBlocked) != 0;
  row.is_in_debt = (out.flags & runtime::kFlagHeldBack) != 0;
  return row;
}

// Where a path stands to the surface that answers: what a user must know of forces that are zero.
class PathOnBody {
 public:
  PathOnBody(const runtime::AssetView& asset, const TipPath& path, const std::string& file)
      : asset_(asset), path_(path), body_(surface_of(asset)), boxes_(triangle_boxes(body_)) {
    if (const auto unit = misread_unit(path.position, body_))
      throw Error(file,
                  fmt::format("its columns are in metres, and so it passes the body {:.3g} m away; "
                              "in {} it would lie at the body",
                              nearest_m(), *unit),
                  fmt::format("Write x_m, y_m and z_m in metres: they look like {}.", *unit));
  }

  void say_begin() const {
    const auto near = closest_point(body_, boxes_, path_.position.row(0));
    if (near && near->distance_m > kTouching * extent_m(body_.vertices).norm() &&
        is_in_body(path_.position.row(0), *near))
      warn(
          "the path begins {:.3g} mm inside the body, where nothing is felt until the tip has come "
          "out and touches from outside: begin outside",
          1e3 * near->distance_m);
  }
  void say_untouched() const {
    warn(
        "the path never touches the body from outside, so all forces are zero: its nearest row is "
        "{:.3g} mm from surface that answers",
        1e3 * nearest_m());
  }

 private:
  static constexpr double kTouching = 1e-6;  // of the diagonal: an asset's floats

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
    for (Eigen::Index i = 0; i < path_.position.rows(); ++i) {
      const auto near =
          closest_point(body_, boxes_, path_.position.row(i), least_m,
                        [&](const SurfacePoint& p) { return asset_.is_solid(p.triangle); });
      if (near) least_m = near->distance_m;
    }
    return least_m;
  }

  const runtime::AssetView& asset_;
  const TipPath& path_;
  Surface body_;
  BoxTree boxes_;
};

/// The surface as it is shown every so many ticks, for ParaView: the surface moved, and the tool.
class Frames {
 public:
  Frames(const runtime::AssetView& asset, const std::string& folder, int every)
      : asset_(asset), every_(every), rest_(surface_of(asset)), series_(folder) {
    if (every < 1) throw Error("--every", "it is no number of ticks", "Give 1 or more.");
    if (asset.shape.points == 0)
      throw Error("--surface", "the asset does not say how its surface moves",
                  "Make it of samples with surface = true, by `palpate run`.");
    std::filesystem::create_directories(folder);
  }

  void add(std::size_t tick, double time_s, const Vec3& tip, const runtime::Contact& contact,
           const runtime::Output& out) {
    if (tick % static_cast<std::size_t>(every_) != 0) return;
    Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> moved(rest_.vertices.rows(), 3);
    runtime::deform(asset_, contact, 0, 0, asset_.vertices, moved.data());
    const std::vector<double> place(tip.data(), tip.data() + 3),
        force(out.force_on_tool_N, out.force_on_tool_N + 3);
    VtuWriter surface, tool;
    for (VtuWriter* part : {&surface, &tool}) part->add_field("TimeValue", {time_s});
    surface.add_field("tool_position_m", place);
    surface.add_field("force_on_tool_N", force);
    surface.add("displacement_m", 3, std::vector<float>(moved.data(), moved.data() + moved.size()));
    series_.add(time_s, "surface", frames_,
                surface.text({rest_.vertices + moved.cast<double>(), rest_.triangles}, {}));
    tool.add("force_on_tool_N", 3, force);
    series_.add(time_s, "tool", frames_++, tool.text({Points(tip.transpose()), {}}, {}));
  }
  int close() const {
    series_.close();
    return frames_;
  }

 private:
  const runtime::AssetView& asset_;
  int every_;
  Surface rest_;
  VtuSeries series_;
  int frames_ = 0;
};

constexpr NamedOutput kFrames[] = {
    {"path.pvd", "vtu"}, {"surface_000000.vtu", "vtu"}, {"tool_000000.vtu", "vtu"}};

class Replay final : public Command {
 public:
  explicit Replay(Arguments& arguments) {
    arguments.positional("asset", asset_, "Asset to play, asset.palp");
    arguments.positional("path", path_,
                         "Path of the tip in seconds and metres, PATH.csv: t_s,x_m,y_m,z_m");
    arguments.output("-o,--output", output_,
                     "FORCES.csv to write, with forces on the tool in newtons", {"t_s,fx_N"});
    arguments.option("--realtime", rate_Hz_,
                     "Rate in Hz at which rows are played on the real-time clock, with a second "
                     "thread for first "
                     "touch; 0 plays as fast as possible");
    arguments.option("--surface", surface_,
                     "Folder for path.pvd and its frames: how the surface moves, for ParaView");
    arguments.named_outputs(surface_, kFrames);
    arguments.option("--every", every_, "Ticks from one frame to the next");
  }

  int run(Reply& reply) override {
    const AssetFile file = read_asset_file(asset_);
    const TipPath path = read_tip_path(path_);
    warn_of_unused(path_, path.ignored);
    if (rate_Hz_ != 0 && !surface_.empty())
      throw Error("--surface", "frames are not written in real time",
                  "Leave --realtime out: the forces are the same.");
    const PathOnBody on_body(file.asset(), path, path_);
    std::optional<Frames> frames;
    if (!surface_.empty()) frames.emplace(file.asset(), surface_, every_);
    const std::vector<PlayedTick> played =
        rate_Hz_ != 0 ? play_live(file.asset(), path) : play(file.asset(), path, frames);
    std::vector<ForceRow> rows;
    rows.reserve(played.size());
    std::size_t faults = 0, touching = 0, beyond = 0;
    for (std::size_t i = 0; i < played.size(); ++i) {
      if (played[i].status != runtime::Status::ok && ++faults <= kFaultsShown)
        say_failed("{}: tick {} at {} s: {}", path_, i + 1, path.time_s[i],
                   runtime::sentence(played[i].status));
      rows.push_back(to_row(path.time_s[i], played[i].out));
      touching += rows.back().is_in_contact;
      beyond += rows.back().is_extrapolated;
    }
    on_body.say_begin();
    if (touching == 0) on_body.say_untouched();
    if (beyond > 0)
      warn("{} of {} ticks in contact go beyond the curves, and their forces are extrapolated",
           beyond, touching);
    write_forces(output_, rows);
    const std::int64_t guarded = played.empty() ? 0 : played.back().out.refused_ticks;
    say("wrote {}: {} ticks, {} in contact, {} with a fault, {} where the guard acted", output_,
        rows.size(), touching, faults, guarded);
    reply.json = nlohmann::ordered_json{
        {"ticks", rows.size()}, {"in_contact", touching}, {"faults", faults}, {"guarded", guarded}};
    if (frames) {
      reply.json["frames"] = frames->close();
      say("wrote {}/path.pvd: {} frames", surface_, reply.json["frames"].get<int>());
    }
    return faults ? kSomeFailed : kDone;
  }

 private:
  static std::vector<PlayedTick> play(const runtime::AssetView& asset, const TipPath& path,
                                      std::optional<Frames>& frames) {
    runtime::Contact contact;
    std::vector<PlayedTick> played(path.time_s.size());
    for (std::size_t i = 0; i < played.size(); ++i) {
      const Vec3 tip = path.position.row(static_cast<Eigen::Index>(i));
      const double dt_s = i > 0 ? path.time_s[i] - path.time_s[i - 1] : runtime::kCheckTick_s;
      played[i].status = runtime::touch(asset, contact, tip.data(), played[i].out, nullptr, dt_s);
      if (frames) frames->add(i, path.time_s[i], tip, contact, played[i].out);
    }
    return played;
  }
  std::vector<PlayedTick> play_live(const runtime::AssetView& asset, const TipPath& path) const {
    std::vector<PlayedTick> played;
    const RealtimeReport report =
        play_in_real_time(asset, path.position, rate_Hz_, played, is_interrupted);
    if (report.ticks < path.time_s.size()) throw Interrupted("replay: nothing was written");
    say("{} ticks at {} Hz, {} deadlines missed; {}", report.ticks, rate_Hz_, report.missed,
        report.remark.empty() ? "SCHED_FIFO, memory locked" : report.remark);
    say("{} touches found by the search thread, their force at most {} ticks late", report.touches,
        report.worst_touch_delay);
    say("{}", histogram("jitter of the clock", report.jitter_ns));
    say("{}", histogram("time of a tick", report.tick_ns));
    return played;
  }

  static constexpr std::size_t kFaultsShown = 10;
  std::string asset_, path_, output_, surface_;
  int rate_Hz_ = 0, every_ = 20;
};

}  // namespace

std::unique_ptr<Command> declare_replay(Arguments& arguments) {
  return std::make_unique<Replay>(arguments);
}

}  // namespace palpate::tools
