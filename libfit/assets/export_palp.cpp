#include <string_view>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/assets/engine_folder.hpp"
#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

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
