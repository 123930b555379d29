#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/asset/format.hpp"
#include "tools/command.hpp"

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

Reply answer_of(const AssetFile& file) {
  const runtime::Asset& asset = file.asset();
  const auto vertices_of = [&](int kind) {
    return std::count(asset.covered, asset.covered + asset.vertices, kind);
  };
  const auto family = static_cast<CurveFamily>(asset.curves.family);
  std::string text = fmt::format(
      "palpate asset version {}, {} bytes\n"
      "  {} vertices ({} measured, {} with the body's mean), {} triangles\n"
      "  origin ({}, {}, {}) m, probe radius {} m, guard {}\n"
      "  family {}",
      asset.version, file.bytes(), asset.vertices, vertices_of(runtime::kMeasured),
      vertices_of(runtime::kMean), asset.triangles, asset.origin_m[0], asset.origin_m[1],
      asset.origin_m[2], asset.probe_radius_m, asset.has_guard ? "on" : "off", name_of(family));
  for (std::size_t part = 0; part < parts_of(family).size(); ++part) {
    const runtime::SplineView& spline = asset.curves.view[part];
    if (spline.pieces > 0)
      text += fmt::format("\n  {:<8} {} pieces of degree {} to {} m", parts_of(family)[part].name,
                          spline.pieces, spline.degree, spline.knots[spline.pieces]);
  }
  text += fmt::format("\n  check path: {} ticks, reproduced bit for bit\n  meta: {}",
                      asset.check_ticks, file.meta_json());
  const nlohmann::ordered_json json{
      {"schema", "palp"},
      {"version", asset.version},
      {"bytes", file.bytes()},
      {"vertices", asset.vertices},
      {"measured_vertices", vertices_of(runtime::kMeasured)},
      {"mean_vertices", vertices_of(runtime::kMean)},
      {"triangles", asset.triangles},
      {"family", name_of(family)},
      {"range_m", asset.max_fitted_m},
      {"probe_radius_m", asset.probe_radius_m},
      {"has_guard", asset.has_guard},
      {"meta", nlohmann::ordered_json::parse(file.meta_json(), nullptr, false)}};
  return {text, json};
}

class Inspect final : public Command {
 public:
  explicit Inspect(Arguments& arguments) {
    arguments.positional("file", file_,
                         "File to read: body.h5, samples.h5, curves.h5, model.h5 or asset.palp");
  }

  int run(Reply& reply) override {
    reply = is_asset_file(file_) ? answer_of(read_asset_file(file_)) : answer_of(describe(file_));
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
