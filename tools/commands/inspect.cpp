#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/asset/format.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/command.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

// "  body         text", further lines of the text below its first.
std::string row(const std::string& name, const std::string& text) {
  std::string out = fmt::format("\n  {:<12}", name);
  for (const char c : text) {
    out += c;
    if (c == '\n') out.append(14, ' ');
  }
  return out;
}

std::string body_text(const runtime::AssetView& asset, const Surface& surface) {
  // Floats about an origin: 0 comes back as 9e-10.
  const double grain_m = 1e-6 * extent_m(surface.vertices).norm();
  const auto tidy = [&](const Vec3& place) {
    return Vec3((place / grain_m).array().round() * grain_m);
  };
  const Vec3 low = tidy(surface.vertices.colwise().minCoeff()),
             high = tidy(surface.vertices.colwise().maxCoeff());
  const bool is_closed = std::none_of(asset.neighbour, asset.neighbour + 3 * asset.triangles,
                                      [](int other) { return other < 0; });
  return fmt::format(
      "{}, {} surface, {} and {}\nx {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g} mm",
      size_in_words(high - low, 0), is_closed ? "closed" : "open",
      counted(asset.vertices, "vertex", "vertices"),
      counted(asset.triangles, "triangle", "triangles"), 1e3 * low[0], 1e3 * high[0], 1e3 * low[1],
      1e3 * high[1], 1e3 * low[2], 1e3 * high[2]);
}

// What answers with curves of its own, and what with the mean of those.
std::string window_text(const runtime::AssetView& asset, const Surface& surface) {
  double measured_m2 = 0, mean_m2 = 0;
  Points measured(surface.vertices.rows(), 3);
  Eigen::Index count = 0, mean = 0;
  for (int v = 0; v < asset.vertices; ++v) {
    if (asset.covered[v] == runtime::kMeasured) measured.row(count++) = surface.vertices.row(v);
    mean += asset.covered[v] == runtime::kMean;
  }
  for (int t = 0; t < asset.triangles; ++t) {
    if (!asset.is_solid(t)) continue;
    const auto corner = surface.triangles.row(t);
    const bool has_own = std::any_of(corner.begin(), corner.end(),
                                     [&](int v) { return asset.covered[v] == runtime::kMeasured; });
    const Vec3 a = surface.vertices.row(corner[0]), b = surface.vertices.row(corner[1]),
               c = surface.vertices.row(corner[2]);
    (has_own ? measured_m2 : mean_m2) += (b - a).cross(c - a).norm() / 2;
  }
  std::string text = fmt::format("{} with curves of their own, {:.3g} cm2 of {}",
                                 counted(count, "vertex", "vertices"), 1e4 * measured_m2,
                                 size_in_words(extent_m(measured.topRows(count)), 0));
  text += mean > 0 ? fmt::format("\n{} more answer with the body's mean, {:.3g} cm2, flagged", mean,
                                 1e4 * mean_m2)
                   : "\nnothing else answers";
  return text;
}

// "radius_m": 0.008 is "radius 8 mm".
std::string quantity_text(const std::string& key, const Json& value) {
  const auto named = [&](std::string_view unit, double factor, std::string_view shown) {
    const std::string name = key.substr(0, key.size() - unit.size());
    std::string numbers;
    for (const Json& one : value.is_array() ? value : Json::array({value}))
      numbers += (numbers.empty() ? "" : " x ") + number(factor * one.get<double>(), 4);
    return fmt::format("{} {} {}", name, numbers, shown);
  };
  if (key.ends_with("_m")) return named("_m", 1e3, "mm");
  if (key.ends_with("_rad")) return named("_rad", 180 / 3.14159265358979323846, "degrees");
  return fmt::format("{} {}", key, value.is_string() ? value.get<std::string>() : value.dump());
}

std::string probe_text(const runtime::AssetView& asset, const Json& meta) {
  std::string text;
  if (const auto probe = meta.find("probe"); probe != meta.end() && probe->is_object())
    for (const auto& [key, value] : probe->items())
      text += (text.empty() ? "" : ", ") + (key == "shape" && value.is_string()
                                                ? value.get<std::string>()
                                                : quantity_text(key, value));
  else
    text = "not told";
  return text + (asset.probe_radius_m > 0 ? ", played as a ball" : ", played as a point");
}

std::string curves_text(const runtime::AssetView& asset) {
  const auto family = static_cast<CurveFamily>(asset.curves.family);
  std::string text = fmt::format("family {}, fitted to a depth of {:.4g} mm", name_of(family),
                                 1e3 * asset.max_fitted_m);
  for (std::size_t part = 0; part < parts_of(family).size(); ++part)
    if (const runtime::SplineView& spline = asset.curves.view[part]; spline.pieces > 0)
      text += fmt::format("\n{}: {} of degree {}, to {:.4g} mm", parts_of(family)[part].name,
                          counted(spline.pieces, "piece", "pieces"), spline.degree,
                          1e3 * spline.knots[spline.pieces]);
  std::string does;
  const auto add = [&](bool is_so, const std::string& what) {
    if (is_so) does += (does.empty() ? "\nthe body " : ", ") + what;
  };
  add(asset.sways, "sways");
  add(asset.curves.relaxation.branches > 0, "relaxes");
  add(asset.damage.softens(), "softens");
  add(asset.shape.points > 0, "shows how its surface moves");
  add(asset.visual.vertices > 0,
      fmt::format("moves a mesh of {}", counted(asset.visual.vertices, "vertex", "vertices")));
  text += does;
  if (asset.coupling != nullptr) text += "\nseveral tools feel each other";
  return text;
}

// In the words that end a run.
std::string statement_text(const std::string& name, const Json& meta) {
  Json statement = meta.value("statement", Json());
  if (!statement.is_object() || !statement.contains("force_error"))
    return "none: `palpate validate --statement` makes one";
  statement["tick_ns"] = nullptr, statement["asset_bytes"] = 0;  // of one writing of the asset
  const auto stated = validation::parse_statement(statement.dump(), name);
  std::string text = validation::wrapped(validation::verdict(stated));
  text.pop_back();
  return text;
}

// An asset as a page for people, 100 columns wide but for long names. What the file does not hold
// is said to be so.
std::string page_of(const std::string& name, const AssetFile& file) {
  const runtime::Asset& asset = file.asset();
  const Surface surface = palpate::surface_of(asset);
  Json meta = Json::parse(file.meta_json(), nullptr, false);
  if (!meta.is_object()) meta = Json::object();
  std::string made = meta.value("program", std::string("a program that is not told"));
  if (const Json inputs = meta.value(kInputsAttribute, Json()); inputs.is_string())
    made += ", from inputs " + inputs.get<std::string>();
  if (const Json changed = meta.value("changed", Json()); changed.is_object())
    for (const auto& [what, value] : changed.items())
      made += fmt::format(", {} {} at export", what, value.dump());
  return fmt::format("{}: palpate asset, version {}", name, asset.file.version) +
         row("body", body_text(asset, surface)) + row("window", window_text(asset, surface)) +
         row("probe", probe_text(asset, meta)) + row("curves", curves_text(asset)) +
         row("certificate", fmt::format("the guard of slips is {}; `palpate check {}` makes one",
                                        asset.has_guard ? "on" : "OFF", name)) +
         row("statement", statement_text(name, meta)) +
         row("size",
             fmt::format("{} bytes, {} of them meta data; check path of {}, reproduced bit for bit",
                         file.bytes(), asset.file.meta_bytes,
                         counted(asset.check.ticks, "tick", "ticks"))) +
         row("made by", made);
}

Reply answer_of(const FileDescription& file) {
  std::string text = fmt::format("{} version {}", file.schema, file.version);
  Json json{{"schema", file.schema}, {"version", file.version}};
  for (const auto& [name, value] : file.attributes) {
    std::string line = value.substr(0, value.find('\n'));
    if (line.size() > 100) line.resize(100);  // a scene or a statement is shown by its first line
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
  const Json json{{"schema", "palp"},
                  {"version", asset.file.version},
                  {"bytes", file.bytes()},
                  {"vertices", asset.vertices},
                  {"measured_vertices", vertices_of(runtime::kMeasured)},
                  {"mean_vertices", vertices_of(runtime::kMean)},
                  {"triangles", asset.triangles},
                  {"visual_vertices", asset.visual.vertices},
                  {"family", name_of(static_cast<CurveFamily>(asset.curves.family))},
                  {"range_m", asset.max_fitted_m},
                  {"probe_radius_m", asset.probe_radius_m},
                  {"has_guard", asset.has_guard},
                  {"meta", Json::parse(file.meta_json(), nullptr, false)}};
  return {page_of(name, file), json};
}

// How a scene's [probe] ends, for programs that give it to the engine, and how deep the asset knows
// it.
Reply answer_of(const std::string& scene_path, const runtime::AssetView& asset) {
  const Indenter end = meeting_end(scene_path, asset);
  IndenterAssets met(asset);
  const runtime::AssetView* other = met.of(end);
  const double known_m = other != nullptr ? other->max_fitted_m : asset.max_fitted_m;
  const std::vector<double> r_m(end.r_m, end.r_m + end.points),
      slope(end.slope, end.slope + end.points);
  std::string text =
      fmt::format("palpate_indenter: round_end_m {:.9g}, points {}, known to {:.3g} mm",
                  end.round_end_m, end.points, 1e3 * known_m);
  for (std::size_t i = 0; i < r_m.size(); ++i)
    text += fmt::format("\n  r_m {:.9g}, slope {:.9g}", r_m[i], slope[i]);
  return {text,
          {{"round_end_m", end.round_end_m},
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

const CommandRow kInspectCommand{"inspect", "Print what a file holds", declared<Inspect>,
                                 "Assets and files", "inspect asset.palp"};

}  // namespace palpate::tools
