#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/io/csv/tables.hpp"
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
  }

  int run(Reply& reply) override {
    const AssetFile file = read_asset_file(asset_);
    const TipPath path = read_tip_path(path_);
    const std::vector<PlayedTick> played =
        rate_Hz_ != 0 ? play_live(file.asset(), path) : play(file.asset(), path);
    std::vector<ForceRow> rows;
    rows.reserve(played.size());
    std::size_t faults = 0;
    for (std::size_t i = 0; i < played.size(); ++i) {
      if (played[i].status != runtime::Status::ok && ++faults <= kFaultsShown)
        say_failed("{}: tick {} at {} s: {}", path_, i + 1, path.time_s[i],
                   runtime::sentence(played[i].status));
      rows.push_back(to_row(path.time_s[i], played[i].out));
    }
    write_forces(output_, rows);
    const std::int64_t guarded = played.empty() ? 0 : played.back().out.refused_ticks;
    say("wrote {}: {} ticks, {} with a fault, {} where the guard acted", output_, rows.size(),
        faults, guarded);
    reply.json =
        nlohmann::ordered_json{{"ticks", rows.size()}, {"faults", faults}, {"guarded", guarded}};
    return faults ? kSomeFailed : kDone;
  }

 private:
  static std::vector<PlayedTick> play(const runtime::AssetView& asset, const TipPath& path) {
    runtime::Contact contact;
    std::vector<PlayedTick> played(path.time_s.size());
    for (std::size_t i = 0; i < played.size(); ++i) {
      const Vec3 tip = path.position.row(static_cast<Eigen::Index>(i));
      played[i].status = runtime::touch(asset, contact, tip.data(), played[i].out);
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
  std::string asset_, path_, output_;
  int rate_Hz_ = 0;
};

}  // namespace

std::unique_ptr<Command> declare_replay(Arguments& arguments) {
  return std::make_unique<Replay>(arguments);
}

}  // namespace palpate::tools
