#include "libfit/assets/exporters.hpp"

#include <limits>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/vtu.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {
namespace {

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

ExportReport export_vtu(const Model& model, const std::filesystem::path& path,
                        const ExportOptions&) {
  check_sizes(model);
  VtuWriter vtu;
  add_point_data(model, vtu);
  const std::string text = vtu.text(model.surface, "is_covered");
  write_file_atomically(path, text);
  ExportReport report;
  report.bytes = text.size();
  report.vertices = int(model.surface.vertices.rows());
  report.triangles = int(model.surface.triangles.rows());
  return report;
}

}  // namespace palpate
