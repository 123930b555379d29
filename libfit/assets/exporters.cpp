#include "libfit/assets/exporters.hpp"

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {
namespace {

// The row with this value of a column; none: the values there are.
const Exporter* find_row(std::string_view Exporter::*column, std::string_view value,
                         std::string& values) {
  for (const Exporter& exporter : kExporters) {
    if (exporter.*column == value) return &exporter;
    values += (values.empty() ? "" : ", ") + std::string(exporter.*column);
  }
  return nullptr;
}

}  // namespace

bool has_matching_arrays(const Model& model) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  const auto parts = parts_of(model.curves.family);
  const CurveSet& curves = model.curves;
  bool matches = model.inward_normal.rows() == vertices &&
                 std::ssize(model.is_covered) == vertices && curves.basis.size() == parts.size() &&
                 curves.control.size() == parts.size();
  for (std::size_t i = 0; i < parts.size() && matches; ++i)
    matches = curves.control[i].rows() == vertices &&
              curves.control[i].cols() == parts[i].width * size_of(parts[i], curves.basis[i]);
  return matches;
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

const Exporter& find_exporter(std::string_view name) {
  std::string names;
  if (const Exporter* found = find_row(&Exporter::name, name, names)) return *found;
  throw Error("--format", "there is no asset format \"" + std::string(name) + "\"",
              "Choose one of: " + names + ".");
}

const Exporter& exporter_of_file(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  std::string known;
  if (const Exporter* found = find_row(&Exporter::extension, extension, known)) return *found;
  throw Error(path.string(),
              extension.empty() ? "its name does not say a format"
                                : "nothing is exported as \"" + extension + "\"",
              "The name says the format: let it end in one of " + known + ".");
}

}  // namespace palpate
