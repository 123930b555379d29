#pragma once

#include <filesystem>
#include <string>

#include "libfit/assets/exporters.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

struct ExportRequest {
  ExportSection settings;
  std::string fingerprint;       ///< put into the asset's meta; empty for none
  std::string statement;         ///< JSON object put into the asset's meta; empty for none
  double map_depth_m = 0;        ///< of a coloured surface; 0: half of the curves' range
  int jobs = 0;                  ///< threads of a repair; 0: all cores
  std::filesystem::path engine;  ///< folder to copy the engine into; empty for none
};

/// Writes the model in one of the export formats; says what and how large.
ExportReport export_model(const Model& model, const std::filesystem::path& output,
                          const std::string& format, const ExportRequest& request);

}  // namespace palpate::tools
