#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/met_assets.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/asset/format.hpp"
#include "tools/command.hpp"
#include "tools/commands/asset_page.hpp"
#include "tools/stages/samples/compound.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kLongestAttribute = 100;  // a scene or a statement is shown by its first line

Reply answer_of(const FileDescription& file) {
  std::string text = fmt::format("{} version {}", file.schema, file.version);
  nlohmann::ordered_json json{{"schema", file.schema}, {"version", file.version}};
  for (const auto& [name, value] : file.attributes) {
    std::string line = value.substr(0, value.find('\n'));
    if (line.size() > kLongestAttribute) line.resize(kLongestAttribute);
    text += fmt::format("\n  {} = {}{}", name, line, line.size() < value.size() ? " ..." : "");
    json["attributes"][name] = value;
  }
  for (const DataSetDescription& set : file.data_sets) {
    const std::string unit = set.unit == h5::kNoUnit ? "" : set.unit;
    text += fmt::format("\n  {:<28} {:<8} {:<14} {}", set.name, set.type, h5::to_string(set.shape),
                        unit);
    json["data_sets"].push_back({{"name", set.name},
                                 {"type", set.type},
                                 {"shape", h5::to_string(set.shape)},
                                 {"unit", unit}});
  }
  return {text, json};
}

Reply answer_of(const std::string& name, const AssetFile& file) {
  const runtime::Asset& asset = file.asset();
  const auto vertices_of = [&](int kind) {
    return std::count(asset.covered, asset.covered + asset.vertices, kind);
  };
  const nlohmann::ordered_json json{
      {"schema", "palp"},
      {"version", asset.file.version},
      {"bytes", file.bytes()},
      {"vertices", asset.vertices},
      {"measured_vertices", vertices_of(runtime::kMeasured)},
      {"mean_vertices", vertices_of(runtime::kMean)},
      {"triangles", asset.triangles},
      {"family", name_of(static_cast<CurveFamily>(asset.curves.family))},
      {"range_m", asset.max_fitted_m},
      {"probe_radius_m", asset.probe_radius_m},
      {"has_guard", asset.has_guard},
      {"meta", nlohmann::ordered_json::parse(file.meta_json(), nullptr, false)}};
  return {page_of(name, file), json};
}

// How a scene's [probe] ends, for programs that give it to the engine, and how deep the asset knows
// it.
Reply answer_of(const std::string& scene_path, const runtime::AssetView& asset) {
  const std::optional<Indenter> end = own_end(read_scene(scene_path));
  if (!end)
    throw Error(scene_path + ": [probe]", "is not round along its press",
                "Name a scene with a ball, a cone or a rod.");
  if (!runtime::knows_radius(asset))
    throw Error("--tool", "the asset was measured with no ball, and knows no other tool",
                "Leave --tool out.");
  MetAssets met(asset);
  const runtime::AssetView* other = met.of(*end);
  const double known_m = other != nullptr ? other->max_fitted_m : asset.max_fitted_m;
  const std::vector<double> r_m(end->r_m, end->r_m + end->points),
      slope(end->slope, end->slope + end->points);
  std::string text =
      fmt::format("palpate_indenter: round_end_m {:.9g}, points {}, known to {:.3g} mm",
                  end->round_end_m, end->points, 1e3 * known_m);
  for (std::size_t i = 0; i < r_m.size(); ++i)
    text += fmt::format("\n  r_m {:.9g}, slope {:.9g}", r_m[i], slope[i]);
  return {text,
          {{"round_end_m", end->round_end_m},
           {"r_m", r_m},
           {"slope", slope},
           {"known_depth_m", known_m}}};
}

class Inspect final : public Command {
 public:
  explicit Inspect(Arguments& arguments) {
    arguments.positional("file", file_,
                         "File to read: body.h5, samples.h5, curves.h5, model.h5 or asset.palp");
    arguments.option("--tool", tool_,
                     "Scene whose [probe] meets an asset: says how it ends, as palpate_indenter");
  }

  int run(Reply& reply) override {
    if (!tool_.empty()) {
      reply = answer_of(tool_, read_asset_file(file_).asset());
      return kDone;
    }
    reply = is_asset_file(file_) ? answer_of(file_, read_asset_file(file_))
                                 : answer_of(describe(file_));
    return kDone;
  }

 private:
  std::string file_, tool_;
};

}  // namespace

std::unique_ptr<Command> declare_inspect(Arguments& arguments) {
  return std::make_unique<Inspect>(arguments);
}

}  // namespace palpate::tools
