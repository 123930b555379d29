#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/asset/format.hpp"
#include "tools/command.hpp"
#include "tools/commands/asset_page.hpp"

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

class Inspect final : public Command {
 public:
  explicit Inspect(Arguments& arguments) {
    arguments.positional("file", file_,
                         "File to read: body.h5, samples.h5, curves.h5, model.h5 or asset.palp");
  }

  int run(Reply& reply) override {
    reply = is_asset_file(file_) ? answer_of(file_, read_asset_file(file_))
                                 : answer_of(describe(file_));
    return kDone;
  }

 private:
  std::string file_;
};

}  // namespace

std::unique_ptr<Command> declare_inspect(Arguments& arguments) {
  return std::make_unique<Inspect>(arguments);
}

}  // namespace palpate::tools
