#include "libfit/assets/exporters.hpp"

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {
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

}  // namespace palpate
