#include "libfit/assets/exporters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/vtu.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {
namespace {

// The page reads the same file (tools/page/src/colours.ts).
constexpr std::uint8_t kAnchors[] = {
#include "libfit/assets/viridis.inc"
};
constexpr std::size_t kIntervals = std::size(kAnchors) / 3 - 1;

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A viewer must not take for soft a place where nothing is known.
template <class F>
std::vector<float> per_vertex(const Model& model, F value) {
  std::vector<float> out;
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    out.push_back(model.is_covered[v] ? float(value(v)) : std::numeric_limits<float>::quiet_NaN());
  return out;
}

std::string at_depth(double depth_m) {  // "_at_2.5mm"
  std::string digits = std::to_string(depth_m * 1e3);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return "_at_" + digits + "mm";
}

void add_point_data(const Model& model, VtuWriter& vtu) {
  const NodeForces forces(model.curves);
  vtu.add("is_covered", 1, std::vector<char>(model.is_covered));
  vtu.add("inward_normal", 3,
          std::vector<double>(model.inward_normal.data(),
                              model.inward_normal.data() + model.inward_normal.size()));
  for (double share : {0.25, 0.5, 0.75, 1.0}) {  // of the normal curve's range
    const double depth = share * model.curves.basis[0].knots_m.back();
    const std::string at = at_depth(depth);
    const auto force = [&](Eigen::Index v) { return forces.normal_N(v, depth); };
    const auto mu = [&](Eigen::Index v) {
      return force(v) > 0 ? forces.limit_N(v, depth) / force(v) : 0;
    };
    vtu.add("normal_force_N" + at, 1, per_vertex(model, force));
    vtu.add("normal_stiffness_N_m" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.normal_slope_N_m(v, depth); }));
    vtu.add("lateral_stiffness_N_m" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.lateral_slope_N_m(v, depth); }));
    vtu.add("friction_limit_N" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.limit_N(v, depth); }));
    vtu.add("friction" + at, 1, per_vertex(model, mu));
  }
}

}  // namespace

void check_sizes(const Model& model) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  const auto parts = parts_of(model.curves.family);
  const CurveSet& curves = model.curves;
  bool matches = model.inward_normal.rows() == vertices &&
                 std::ssize(model.is_covered) == vertices && curves.basis.size() == parts.size() &&
                 curves.control.size() == parts.size();
  for (std::size_t i = 0; i < parts.size() && matches; ++i)
    matches = curves.control[i].rows() == vertices &&
              curves.control[i].cols() == parts[i].width * size_of(parts[i], curves.basis[i]);
  if (vertices == 0 || !matches)
    throw Error(
        "model",
        "it has no vertices, or the arrays of vertices, normals, coverage and controls differ "
        "in size",
        "Make the model again with `palpate refine`.");
}

void write_engine_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure)
    throw Error(folder.string(), "the engine's folder cannot be made: " + failure.message(),
                "Choose a folder that can be written.");
  const bool is_engine = std::filesystem::exists(folder / "palpate.h");
  for (const EngineFile& file : engine_files())
    if (!is_engine && std::filesystem::exists(folder / std::filesystem::path(file.name)))
      throw Error((folder / std::filesystem::path(file.name)).string(),
                  "is there already, in a folder that holds no engine",
                  "Move it away, or give the engine a folder of its own.");
  for (const EngineFile& file : engine_files()) {
    const auto path = folder / std::filesystem::path(file.name);
    std::filesystem::create_directories(path.parent_path(), failure);
    write_file_atomically(path, file.text);
  }
}

ExportReport export_palp(const Model& model, const std::filesystem::path& path,
                         const ExportOptions& options) {
  ExportReport report;
  const AssetBytes bytes = make_asset_bytes(model, options, &report);
  runtime::Status status;
  runtime::Asset::open(bytes.data(), bytes.size(), &status);
  if (status != runtime::Status::ok)
    throw Error(path.string(),
                std::string("the new asset does not open: ") + runtime::sentence(status),
                "Report this: the engine refuses what it has just recorded.");
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!options.engine_dir.empty()) write_engine_folder(options.engine_dir);
  return report;
}

ExportReport written(const Model& model, std::uint64_t bytes) {
  ExportReport report;
  report.bytes = bytes;
  report.vertices = int(model.surface.vertices.rows());
  report.triangles = int(model.surface.triangles.rows());
  return report;
}

const Exporter& exporter_of_file(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  std::string known;
  for (const Exporter& exporter : kExporters) {
    if (exporter.extension == extension) return exporter;
    known += (known.empty() ? "" : ", ") + std::string(exporter.extension);
  }
  throw Error(path.string(),
              extension.empty() ? "its name does not say a format"
                                : "nothing is exported as \"" + extension + "\"",
              "The name says the format: let it end in one of " + known + ".");
}

Rgb viridis(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * kIntervals;
  const std::size_t k = std::min(std::size_t(at), kIntervals - 1);
  Rgb out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = kAnchors[3 * k + i], high = kAnchors[3 * k + 3 + i];
    out[i] = static_cast<std::uint8_t>(std::lround(low + (at - double(k)) * (high - low)));
  }
  return out;
}

StiffnessMap stiffness_map(const Model& model, double depth_m) {
  check_sizes(model);
  const double range_m = model.curves.basis[0].knots_m.back();
  if (!(depth_m >= 0 && depth_m <= range_m))
    throw Error("--depth", "it lies beyond the curves, which end at " + millimetres(range_m),
                "Give a depth up to there.");
  StiffnessMap map;
  map.depth_m = depth_m > 0 ? depth_m : range_m / 2;
  map.low_N_m = std::numeric_limits<double>::infinity();
  const NodeForces forces(model.curves);
  for (std::size_t v = 0; v < model.is_covered.size(); ++v) {
    const double slope = model.is_covered[v] ? forces.normal_slope_N_m(v, map.depth_m)
                                             : std::numeric_limits<double>::quiet_NaN();
    map.stiffness_N_m.push_back(float(slope));
    if (!model.is_covered[v]) continue;
    map.low_N_m = std::min(map.low_N_m, slope);
    map.high_N_m = std::max(map.high_N_m, slope);
  }
  const double width = map.high_N_m - map.low_N_m;
  for (std::size_t v = 0; v < model.is_covered.size(); ++v)
    map.colour.push_back(!model.is_covered[v] ? kUncoveredGrey
                         : width > 0 ? viridis((map.stiffness_N_m[v] - map.low_N_m) / width)
                                     : viridis(0.5));
  return map;
}

/// Source: Turk, The PLY Polygon File Format (1994); binary, little-endian.
ExportReport export_ply(const Model& model, const std::filesystem::path& path,
                        const ExportOptions& options) {
  const StiffnessMap map = stiffness_map(model, options.map_depth_m);
  const Surface& surface = model.surface;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment palpate: metres; normal stiffness at a depth "
      "of " +
      std::to_string(map.depth_m) + " m, coloured from " + std::to_string(map.low_N_m) + " to " +
      std::to_string(map.high_N_m) +
      " N/m; grey and NaN where nothing was measured\nelement vertex " +
      std::to_string(surface.vertices.rows()) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty float normal_stiffness_N_m\nelement "
      "face " +
      std::to_string(surface.triangles.rows()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) append(bytes, surface.vertices(v, k));
    for (const std::uint8_t part : map.colour[v]) append(bytes, part);
    append(bytes, map.stiffness_N_m[v]);
  }
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    append(bytes, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) append(bytes, surface.triangles(t, k));
  }
  write_file_atomically(path, bytes);
  return written(model, bytes.size());
}

ExportReport export_vtu(const Model& model, const std::filesystem::path& path,
                        const ExportOptions&) {
  check_sizes(model);
  VtuWriter vtu;
  add_point_data(model, vtu);
  const std::string text = vtu.text(model.surface, "is_covered");
  write_file_atomically(path, text);
  return written(model, text.size());
}

}  // namespace palpate
