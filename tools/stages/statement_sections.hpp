#pragma once

#include <filesystem>
#include <vector>

#include "libfit/validation/statement.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {

/// What a section is made of. asset: as it is; met: as the scene's probe meets it, the same where
/// it is that of the asset. engine: what `met` answered to reference.paths. radius_m: of the
/// probe's round end, about whose centre torques are compared (M58a). floors: of the paths.
struct StatedAsset {
  const runtime::AssetView &asset, &met;
  const Scene& scene;
  const SimulatedReference& reference;
  const validation::Replayed& engine;
  double radius_m;
  validation::ErrorFloors floors;
  const ValidateRequest& request;
};

/// All sections of the table, in its order; those that say nothing of this asset have no lines.
std::vector<validation::StatementSection> statement_sections(const StatedAsset& of);

/// Reference and answer of every good row that a section is of, as validation.csv.
void write_compared_rows(const std::filesystem::path& path, const StatedAsset& of);

}  // namespace palpate::tools
