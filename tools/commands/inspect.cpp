#include <fmt/core.h>
#include <algorithm>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/format.hpp"
#include "tools/command.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kLongestAttribute = 100;  // a scene or a statement is shown by its first line

void print(const FileDescription& file) {
  fmt::print("{} version {}\n", file.schema, file.version);
  for (const auto& [name, value] : file.attributes) {
    std::string line = value.substr(0, value.find('\n'));
    if (line.size() > kLongestAttribute) line.resize(kLongestAttribute);
    fmt::print("  {} = {}{}\n", name, line, line.size() < value.size() ? " ..." : "");
  }
  for (const DataSetDescription& set : file.data_sets)
    fmt::print("  {:<28} {:<8} {:<14} {}\n", set.name, set.type, h5::to_string(set.shape),
               set.unit == h5::kNoUnit ? "" : set.unit);
}

void print_asset(const std::filesystem::path& path) {
  const AssetFile file = read_asset_file(path);
  const runtime::Asset& asset = file.asset();
  const auto covered = std::count(asset.covered, asset.covered + asset.vertices, 1);
  fmt::print("palpate asset version {}, {} bytes\n", asset.version, file.bytes());
  fmt::print("  {} vertices ({} covered), {} triangles\n", asset.vertices, covered,
             asset.triangles);
  fmt::print("  origin ({}, {}, {}) m, probe radius {} m, guard {}\n", asset.origin_m[0],
             asset.origin_m[1], asset.origin_m[2], asset.probe_radius_m,
             asset.has_guard ? "on" : "off");
  const auto family = static_cast<CurveFamily>(asset.curves.family);
  fmt::print("  family {}\n", name_of(family));
  for (std::size_t part = 0; part < parts_of(family).size(); ++part) {
    const runtime::SplineView& spline = asset.curves.view[part];
    if (spline.pieces > 0)
      fmt::print("  {:<8} {} pieces of degree {} to {} m\n", parts_of(family)[part].name,
                 spline.pieces, spline.degree, spline.knots[spline.pieces]);
  }
  fmt::print("  check path: {} ticks, reproduced bit for bit\n", asset.check_ticks);
  fmt::print("  meta: {}\n", file.meta_json());
}

class Inspect final : public Command {
 public:
  explicit Inspect(Arguments& arguments) {
    arguments.positional("file", file_,
                         "File to read: body.h5, samples.h5, curves.h5, model.h5 or asset.palp");
  }

  int run() override {
    if (is_asset_file(file_))
      print_asset(file_);
    else
      print(describe(file_));
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
