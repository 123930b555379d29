#include <fmt/format.h>

#include "libfit/assets/asset_file.hpp"
#include "libfit/io/tables.hpp"
#include "libfit/runtime/engine.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"

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
  return row;
}

class Replay final : public Command {
 public:
  explicit Replay(Arguments& arguments) {
    arguments.positional("asset", asset_, "asset.palp");
    arguments.positional("path", path_, "PATH.csv: t_s,x_m,y_m,z_m of the tip");
    arguments.option("-o,--output", output_, "FORCES.csv to write; forces are those on the tool", true);
  }

  int run() override {
    const AssetFile file = read_asset_file(asset_);
    const TipPath path = read_tip_path(path_);
    runtime::Contact contact;
    std::vector<ForceRow> rows;
    rows.reserve(path.time_s.size());
    std::size_t faults = 0;
    for (std::size_t i = 0; i < path.time_s.size(); ++i) {
      const Vec3 tip = path.position.row(static_cast<Eigen::Index>(i));
      runtime::Output out;
      const runtime::Status status = runtime::touch(file.asset(), contact, tip.data(), out);
      if (status != runtime::Status::ok && ++faults <= kFaultsShown)
        say("{}: tick {} at {} s: {}", path_, i + 1, path.time_s[i], runtime::sentence(status));
      rows.push_back(to_row(path.time_s[i], out));
    }
    write_forces(output_, rows);
    say("wrote {}: {} ticks, {} with a fault, {} where the guard acted", output_, rows.size(), faults, contact.refused_ticks);
    return faults ? kSomeFailed : kDone;
  }

 private:
  static constexpr std::size_t kFaultsShown = 10;
  std::string asset_, path_, output_;
};

}  // namespace

std::unique_ptr<Command> declare_replay(Arguments& arguments) { return std::make_unique<Replay>(arguments); }

}  // namespace palpate::tools
