#include "tools/certify/repair.hpp"

#include <fmt/format.h>

#include <optional>

#include "libfit/assets/asset_file.hpp"
#include "libfit/certify/cap.hpp"
#include "libfit/certify/repair.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/console.hpp"
#include "tools/scene/devices.hpp"

namespace palpate::tools {
namespace {

using certify::ForceChange;
using certify::Uncertified;
using Json = nlohmann::ordered_json;

constexpr int kSlopes = 100;  // of a curve that are looked at

Json to_json(const Uncertified& open) {
  return {{"triangles", open.any},
          {"area", open.any_area},
          {"witnesses", open.witnesses},
          {"gross_slip_triangles", open.gross},
          {"gross_slip_area", open.gross_area},
          {"pulling_triangles", open.pulling}};
}
Json to_json(const ForceChange& change) {
  return {
      {"p95_N", change.p95_N}, {"max_N", change.max_N}, {"p95", change.p95}, {"max", change.max}};
}
Json to_json(const certify::Repair& repair) {
  Json steps = Json::array();
  for (const certify::RepairStep& step : repair.steps)
    steps.push_back({{"kind", step.kind->name},
                     {"kept", step.is_kept},
                     {"vertices", step.vertices},
                     {"uncertified", to_json(step.after)},
                     {"force_change", to_json(step.change)}});
  return {{"before", to_json(repair.before)},
          {"after", to_json(repair.after)},
          {"force_change", to_json(repair.change)},
          {"steps", steps}};
}

std::string in_words(const Uncertified& open) {
  std::string out = fmt::format("{} triangles ({:.1f} %)", open.any, 100 * open.any_area);
  if (open.gross > 0) out += fmt::format(", {} in gross slip", open.gross);
  if (open.pulling > 0) out += fmt::format(", {} that may pull", open.pulling);
  return out + fmt::format(", {} witnesses", open.witnesses);
}
std::string in_words(const ForceChange& change) {
  return fmt::format("{:.3g} N ({:.1f} %) at p95 and {:.3g} N ({:.1f} %) at most", change.p95_N,
                     100 * change.p95, change.max_N, 100 * change.max);
}
std::string in_words(const certify::Repair& repair) {
  if (repair.before.sum() == 0) return "Nothing to repair.";
  std::string out = fmt::format("Repair. Not certified before: {}.\n", in_words(repair.before));
  for (const certify::RepairStep& step : repair.steps)
    out += fmt::format("  {}: {} at {} vertices; {} left; forces change by {}\n",
                       step.is_kept ? "kept" : "undone", step.kind->what, step.vertices,
                       in_words(step.after), in_words(step.change));
  return out + fmt::format("Not certified after: {}. Forces change by {} in all.",
                           in_words(repair.after), in_words(repair.change));
}

std::string meta_of(const AssetFile& file, const Json& done) {
  Json meta = Json::parse(file.meta_json(), nullptr, false);
  if (!meta.is_object()) meta = Json::object();
  if (meta.contains("statement")) {
    meta["statement_before_repair"] = meta["statement"];
    meta.erase("statement");
  }
  meta["repair"] = done;
  return meta.dump();
}

// What a device makes of an asset.
struct Cap {
  AssetEdit asset;
  double stiffness_N_m = 0, steepest_N_m = 0;  // shown; of the body before
  ForceChange change;
};
certify::Device find_device(const RepairRequest& request) {
  std::string names;
  for (certify::Device& device : read_devices(request.devices)) {
    if (device.name == request.device) return device;
    names += (names.empty() ? "" : ", ") + device.name;
  }
  throw Error("--device", "\"" + request.device + "\" is no device of the table",
              "Use one of: " + names + "; or name a table with --devices.");
}
Cap cap_for(const runtime::AssetView& asset, const certify::Device& device) {
  Cap out{AssetEdit(asset), 0, 0, {}};
  const runtime::SplineView& curve = asset.curves.view[runtime::kNormal];
  double most_N = 0;
  for (int v = 0; v < asset.vertices; ++v) {
    if (!asset.covered[v]) continue;
    const float* control = asset.node(v) + asset.control_offset[runtime::kNormal];
    most_N = std::max(most_N, runtime::curve_value(curve, control, asset.max_fitted_m));
    for (int i = 0; i <= kSlopes; ++i)
      out.steepest_N_m = std::max(
          out.steepest_N_m, runtime::curve_slope(curve, control, asset.max_fitted_m * i / kSlopes));
  }
  out.stiffness_N_m = certify::stiffness_shown_N_m(device, most_N);
  if (out.steepest_N_m > out.stiffness_N_m) out.asset = certify::capped(asset, out.stiffness_N_m);
  out.change = certify::force_change(asset, out.asset.asset(), asset.probe_radius_m);
  return out;
}

}  // namespace

RepairAnswer repair_asset(const RepairRequest& request) {
  std::optional<certify::Device> device;
  if (!request.device.empty()) device = find_device(request);
  const AssetFile file = read_asset_file(request.asset);
  const runtime::Asset& asset = file.asset();
  if (asset.curves.family != static_cast<int>(runtime::Family::rings))
    throw Error(request.asset.string(), "sliding is certified, and repaired, for rings alone",
                "Leave the repair out: the guard of the engine keeps such an asset passive.");
  certify::RepairOptions options;
  options.facet.radius_m = asset.probe_radius_m;
  options.threads = job_count(request.jobs);
  ConsoleProgress progress("repairing");
  std::optional<Cap> cap;
  if (device) cap = cap_for(asset, *device);
  certify::Repair repair =
      certify::repair(cap ? cap->asset.asset() : asset, options, progress.progress());
  if (is_interrupted()) throw Interrupted("repair: nothing was written");
  RepairAnswer out{in_words(repair), to_json(repair)};
  if (cap) {
    out.json["cap"] = {{"device", request.device},
                       {"stiffness_N_m", cap->stiffness_N_m},
                       {"steepest_N_m", cap->steepest_N_m},
                       {"force_change", to_json(cap->change)}};
    out.text =
        fmt::format("{} shows {:.0f} N/m at rest; the body's steepest curve has {:.0f}. {}\n",
                    request.device, cap->stiffness_N_m, cap->steepest_N_m,
                    cap->change.max_N > 0
                        ? "Curves are capped: forces change by " + in_words(cap->change) + "."
                        : "Nothing is capped.") +
        out.text;
  }
  repair.asset.seal(meta_of(file, out.json));
  const AssetBytes& bytes = repair.asset.bytes();
  write_file_atomically(request.output,
                        {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return out;
}

}  // namespace palpate::tools
