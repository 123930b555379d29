#include "tools/certify/certify.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libfem/probes/probes.hpp"
#include "libfem/probes/round_end.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/certify/certificate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/experiments/met_assets.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/vtu.hpp"
#include "tools/console.hpp"
#include "tools/scene/devices.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {
namespace {

using certify::Certificate;
using certify::DeviceVerdict;
using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(); }

Json to_json(const certify::Witness& w) {
  return {{"triangle", w.triangle},         {"weights", w.weight},      {"depth_m", w.depth_m},
          {"deflection_m", w.deflection_m}, {"direction", w.direction}, {"created_J", w.created_J},
          {"stored_J", w.stored_J}};
}

Json to_json(const certify::SlidingFigures& figures) {
  Json causes = Json::object(), witnesses = Json::array();
  for (std::size_t i = 1; i < std::size(certify::kCauseNames); ++i)
    if (figures.cause_share[i] > 0) causes[certify::kCauseNames[i]] = figures.cause_share[i];
  for (const certify::Witness& witness : figures.witnesses) witnesses.push_back(to_json(witness));
  return {{"passive", figures.is_passive()},
          {"certified", figures.certified},
          {"failed", figures.failed},
          {"undecided", figures.undecided},
          {"certified_area", figures.certified_area},
          {"depth_share", figures.depth_share},
          {"friction_factor", number(figures.factor_required)},
          {"friction_factor_found", figures.factor_found},
          {"mu_required", number(figures.mu_required)},
          {"causes", causes},
          {"witnesses", witnesses}};
}

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
  const certify::Continuity& k = c.continuity;
  Json damping = Json::object(), radii = Json::array(), verdicts = Json::array();
  for (const int rate : certify::kRates_Hz)
    damping[std::to_string(rate)] = certify::least_damping_Ns_m(k.stiffness_N_m, rate);
  for (const auto& tool : c.tools) radii.push_back(tool.radius_m);
  for (const DeviceVerdict& device : devices) verdicts.push_back(to_json(device));
  Json out = {{"certified", c.certified()},
              {"of_slow_motion", c.relaxes},
              {"of_unpressed_body", c.softens},
              {"of_one_contact", c.couples},
              {"passive_fixed", c.passive_fixed},
              {"passive_sliding", c.passive_sliding()},
              {"mu_required", c.is_rings ? number(c.any.mu_required) : Json()},
              {"k_max_N_m", k.stiffness_N_m},
              {"b_min_Ns_m", damping},
              {"edge_jump_N", k.edge_N},
              {"failed_elements", c.any.failed + c.any.undecided},
              {"family", c.family},
              {"radii_m", radii},
              {"max_depth_m", c.max_depth_m},
              {"pulling_elements", c.pulling},
              {"least_slope_N_m", number(c.least_slope_N_m)},
              {"certified_interior", c.passive_sliding()},
              {"interior_elements", c.interior},
              {"skirt_elements", c.skirt},
              {"skirt_area", c.skirt_area},
              {"mean_elements", c.mean},
              {"mean_area", c.mean_area},
              {"continuity",
               {{"sampled_ticks", k.ticks},
                {"touch_N", k.touch_N},
                {"release_N", k.release_N},
                {"edge_N", k.edge_N},
                {"knot_N", k.knot_N},
                {"range_end_N", k.range_end_N},
                {"held_back_N", k.held_N},
                {"inside_N", k.inside_N},
                {"force_N", k.force_N}}},
              {"devices", verdicts}};
  if (c.is_rings && c.sways) {
    out["seen_step_m"] = c.seen_step_m;
    out["seen_step_sampled_m"] = k.seen_m;
  }
  if (c.is_rings) {
    out["least_friction"] = number(c.least_friction);
    out["sliding"] = to_json(c.any);
    out["gross_slip"] = to_json(c.gross);
  }
  return out;
}

// Triangle by triangle, each with corners of its own, so that a viewer shows its numbers flat.
void write_map(const std::string& path, const runtime::AssetView& asset, const Certificate& c) {
  Surface surface;
  surface.vertices.resize(3 * asset.triangles, 3);
  surface.triangles.resize(asset.triangles, 3);
  for (int t = 0; t < asset.triangles; ++t)
    for (int k = 0; k < 3; ++k) {
      const runtime::Vec3d p = asset.vertex_at(asset.corner(t, k));
      surface.vertices.row(3 * t + k) << p.x + asset.origin_m[0], p.y + asset.origin_m[1],
          p.z + asset.origin_m[2];
      surface.triangles(t, k) = 3 * t + k;
    }
  VtuWriter vtu;
  std::vector<char> zone;
  for (int t = 0; t < asset.triangles; ++t)
    zone.insert(zone.end(), 3, static_cast<char>(c.zone[static_cast<std::size_t>(t)]));
  vtu.add("zone", 1, zone);
  for (const auto& tool : c.tools) {
    const std::string of =
        tool.radius_m > 0 ? fmt::format("_ball_{:g}mm", 1e3 * tool.radius_m) : "_tip";
    std::vector<float> any, gross;
    std::vector<char> verdict, cause;
    for (const certify::Sliding& sliding : tool.any) {
      any.insert(any.end(), 3, static_cast<float>(sliding.ratio));
      verdict.insert(verdict.end(), 3, static_cast<char>(sliding.verdict));
      cause.insert(cause.end(), 3, static_cast<char>(sliding.cause));
    }
    for (const certify::Sliding& sliding : tool.gross)
      gross.insert(gross.end(), 3, static_cast<float>(sliding.ratio));
    if (any.empty()) continue;
    vtu.add("friction_factor" + of, 1, any);
    vtu.add("friction_factor_gross_slip" + of, 1, gross);
    vtu.add("verdict" + of, 1, verdict);
    vtu.add("cause" + of, 1, cause);
  }
  write_file_atomically(path, vtu.text(surface, "zone"));
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
const runtime::AssetView& met_by(const std::string& path, MetAssets& met, const AssetFile& file) {
  const Scene scene = read_scene(path);
  const auto end = fem::round_end(fem::make_probe(scene.probe.spec, path + ": [probe]"));
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
  const std::vector<certify::Device> table = read_devices(check.devices);
  certify::CertifyOptions options;
  MetAssets met(file.asset());
  const runtime::AssetView& asset =
      check.tool.empty() ? file.asset() : met_by(check.tool, met, file);
  options.radii_m = {asset.probe_radius_m};  // a tip stands for the probe's ball
  options.threads = job_count(check.jobs);
  const double start_s = wall_seconds();
  ConsoleProgress progress("certifying");
  const Certificate certificate = certify::certify(asset, options, progress.progress());
  const double seconds = wall_seconds() - start_s;
  if (is_interrupted()) throw Interrupted("check: nothing was written");
  std::vector<DeviceVerdict> devices;
  for (const certify::Device& device : table)
    devices.push_back(certify::judge(device, certificate.continuity.stiffness_N_m,
                                     certificate.continuity.force_N));
  if (!check.vtu.empty()) write_map(check.vtu, asset, certificate);
  AssetAnswer out;
  out.is_certified = certificate.certified();
  out.json = {{"asset", check.asset}};
  out.json.update(to_json(certificate, devices));
  out.json["seconds"] = seconds;
  out.text = fmt::format("{}\n\nDevices:\n{}{:.1f} s", wrapped(certify::in_words(certificate)),
                         device_words(devices), seconds);
  return out;
}

}  // namespace palpate::tools
