#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libfit/assets/exporters.hpp"
#include "tools/stages/samples/compound.hpp"

namespace palpate::tools {

struct ExportRequest {
  std::string fingerprint;            ///< put into the asset's meta; empty for none
  double map_depth_m = 0;             ///< of a coloured surface; 0: half of the curves' range
  std::filesystem::path engine;       ///< folder to copy the engine into; empty for none
  std::vector<NamedTool> tools = {};  ///< of the scene, put into the asset's meta
  /// kGuessedAttribute of the model: warned of, and put into the asset's meta; empty for none.
  std::string guessed_points = {};
};

/// Writes the model in one of the export formats; says what and how large.
ExportReport export_model(const Model& model, const std::filesystem::path& output,
                          const std::string& format, const ExportRequest& request);

/// The probe that curves were made with, as an asset's meta says it (docs/formats/asset.md): JSON,
/// in SI; of a mesh how large it is, not all of it.
std::string probe_meta(const ProbeSpec& probe);

/// Puts a statement of error, a JSON object, into an asset's meta data; nothing else changes.
void put_statement(const std::filesystem::path& asset, const std::string& statement);

}  // namespace palpate::tools
