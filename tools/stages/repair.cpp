#include "tools/stages/repair.hpp"

#include <fmt/format.h>

#include "libfit/assets/asset_file.hpp"
#include "libfit/certify/repair.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

using certify::ForceChange;
using certify::Uncertified;
using Json = nlohmann::ordered_json;

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

std::string meta_of(const AssetFile& file, const Json& done, bool is_stated) {
  Json meta = Json::parse(file.meta_json(), nullptr, false);
  if (!meta.is_object()) meta = Json::object();
  if (!is_stated && meta.contains("statement")) {
    meta["statement_before_repair"] = meta["statement"];
    meta.erase("statement");
  }
  meta["repair"] = done;
  return meta.dump();
}

}  // namespace

RepairAnswer repair_asset(const RepairRequest& request) {
  const AssetFile file = read_asset_file(request.asset);
  const runtime::Asset& asset = file.asset();
  if (asset.curves.family != static_cast<int>(runtime::Family::rings) || asset.sways)
    throw Error(request.asset.string(),
                "sliding is certified, and repaired, for rings alone, on a body that does not sway",
                "Leave the repair out: the guard of the engine keeps such an asset passive.");
  certify::RepairOptions options;
  options.facet.radius_m = asset.probe_radius_m;
  options.threads = job_count(request.jobs);
  ConsoleProgress progress("repairing");
  certify::Repair repair = certify::repair(asset, options, progress.progress());
  if (is_interrupted()) throw Interrupted("repair: nothing was written");
  RepairAnswer out{in_words(repair), to_json(repair)};
  repair.asset.seal(meta_of(file, out.json, request.is_stated));
  const AssetBytes& bytes = repair.asset.bytes();
  write_file_atomically(request.output,
                        {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return out;
}

}  // namespace palpate::tools
