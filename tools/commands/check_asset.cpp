#include "tools/commands/check_asset.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/certify/certificate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/met_assets.hpp"
#include "tools/scene/devices.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/compound.hpp"

namespace palpate::tools {
namespace {

using certify::Certificate;
using certify::DeviceVerdict;
using Json = nlohmann::ordered_json;

Json to_json(const DeviceVerdict& verdict) {
  return {{"name", verdict.device.name},
          {"force_fits", verdict.force_fits},
          {"stiffness_fits", verdict.stiffness_fits},
          {"resolution_fits", verdict.resolution_fits},
          {"hands", verdict.hands},
          {"swinging", verdict.swinging},
          {"source", verdict.device.source}};
}

Json to_json(const Certificate& c, const std::vector<DeviceVerdict>& devices) {
  const certify::ForceJumps& jumps = c.jumps;
  Json damping = Json::object(), verdicts = Json::array();
  for (const int rate : certify::kRates_Hz)
    damping[std::to_string(rate)] = certify::least_damping_Ns_m(c.stiffness_N_m, rate);
  for (const DeviceVerdict& device : devices) verdicts.push_back(to_json(device));
  return {
      {"passive_fixed", c.is_passive_fixed()},
      {"k_max_N_m", c.stiffness_N_m},
      {"b_min_Ns_m", damping},
      {"edge_jump_N", jumps.edge_N},
      {"edge_jump_at_m", c.edge_jump_at_m},
      {"guard", {{"held_ticks", c.held_ticks}, {"refused_J", c.refused_J}, {"work_J", c.work_J}}},
      {"continuity",
       {{"sampled_ticks", c.ticks},
        {"pulling_ticks", c.pulling_ticks},
        {"touch_N", jumps.touch_N},
        {"release_N", jumps.release_N},
        {"edge_N", jumps.edge_N},
        {"knot_N", jumps.knot_N},
        {"range_end_N", jumps.range_end_N},
        {"held_back_N", jumps.held_N},
        {"inside_N", jumps.inside_N},
        {"force_N", c.force_N}}},
      {"devices", verdicts}};
}

std::string in_words(const Certificate& c, bool has_guard) {
  const double* at = c.edge_jump_at_m;
  std::string out = fmt::format("In {} ticks of seeded slides the body ", c.ticks);
  out += c.is_passive_fixed()
             ? "never pulled the tool in and never stored less than nothing. "
             : fmt::format("pulled the tool in or stored less than nothing {} times. ",
                           c.pulling_ticks);
  if (!has_guard)
    out += "The asset has no guard. ";
  else if (c.held_ticks == 0)
    out += "The guard never held its force back. ";
  else
    out += fmt::format(
        "The guard held its force back in {:.2g} % of them: slips would have created {:.3g} uJ, "
        "{:.2g} % of the work of the tool. ",
        100 * double(c.held_ticks) / double(c.ticks), 1e6 * c.refused_J,
        100 * c.refused_J / c.work_J);
  return out + fmt::format(
                   "The force changed by at most {:.3g} N in 50 um ({:.0f} N/m): over edges {:.3g} "
                   "N, at ({:.1f}, {:.1f}, {:.1f}) mm, at touch {:.3g} N, at release {:.3g} N. A "
                   "device needs {:.2g} N s/m of its own at 1 kHz.",
                   c.stiffness_N_m * certify::SlideOptions().step_m, c.stiffness_N_m,
                   c.jumps.edge_N, 1e3 * at[0], 1e3 * at[1], 1e3 * at[2], c.jumps.touch_N,
                   c.jumps.release_N, certify::least_damping_Ns_m(c.stiffness_N_m, 1000));
}

// Lines of 80 columns at most.
std::string wrapped(const std::string& text) {
  std::string out;
  std::size_t column = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (column > 0 && column + 1 + (end - at) > 80) {
      out += '\n';
      column = 0;
    } else if (column > 0) {
      out += ' ';
      ++column;
    }
    out += text.substr(at, end - at);
    column += end - at;
    at = end + 1;
  }
  return out;
}

std::string device_words(const std::vector<DeviceVerdict>& devices) {
  std::string out;
  for (const DeviceVerdict& verdict : devices) {
    std::string lacks;
    const auto add = [&](bool fits, const char* what) {
      if (!fits) lacks += (lacks.empty() ? "" : ", ") + std::string(what);
    };
    add(verdict.force_fits, "force");
    add(verdict.stiffness_fits, "stiffness");
    add(verdict.resolution_fits, "friction for its resolution");
    out += fmt::format("  {}: {}", verdict.device.name,
                       lacks.empty() ? "shows this body" : "lacks " + lacks);
    if (verdict.swinging > 0)
      out += fmt::format("; swings in {} of {} simulated hands", verdict.swinging, verdict.hands);
    else if (verdict.hands > 0)
      out += fmt::format("; at rest in {} simulated hands", verdict.hands);
    out += '\n';
  }
  return out;
}

// The asset as the round end of a scene's probe meets it.
const runtime::AssetView& ball_asset(const std::string& path, MetAssets& met,
                                     const AssetFile& file) {
  const Scene scene = read_scene(path);
  const std::optional<Indenter> end = own_end(scene);
  if (!end)
    throw Error(path + ": [probe]",
                fmt::format("is a {} that is not round along its press", scene.probe.spec.shape),
                "Name a scene with a ball, a cone or a rod.");
  if (!runtime::knows_radius(file.asset()))
    throw Error("--tool", "the asset was measured with no ball, and knows no other tool",
                "Leave --tool out.");
  const runtime::AssetView* other = met.of(*end);
  return other != nullptr ? *other : file.asset();
}

}  // namespace

AssetAnswer check_asset(const AssetCheck& check) {
  const AssetFile file = read_asset_file(check.asset);
  MetAssets met(file.asset());
  const runtime::AssetView& asset =
      check.tool.empty() ? file.asset() : ball_asset(check.tool, met, file);
  const Certificate certificate =
      certify::certify(asset, {.radius_m = asset.probe_radius_m});  // a tip stands for the ball
  std::vector<DeviceVerdict> devices;
  for (const certify::Device& device : read_devices(check.devices))
    devices.push_back(certify::judge(device, certificate.stiffness_N_m, certificate.force_N));
  Json json{{"asset", check.asset}, {"radius_m", asset.probe_radius_m}};
  json.update(to_json(certificate, devices));
  return {certificate.is_passive_fixed(),
          {fmt::format("{}\n\nDevices:\n{}", wrapped(in_words(certificate, asset.has_guard)),
                       device_words(devices)),
           json}};
}

}  // namespace palpate::tools
