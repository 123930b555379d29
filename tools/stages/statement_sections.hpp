#pragma once

#include <filesystem>
#include <vector>

#include "libfit/refine/interpolation.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {

/// Recordings of the asset's body: those that it was fitted to, and those held out of the fit at
/// places where it has no curves of its own. Held-out ones at all others are reference.paths, moved
/// onto the asset's surface; as_placed: the same where they were recorded.
/// left_out: what refine() found by leaving points out of the request's curves; null: not known.
struct RecordedReference {
  Samples fitted, beyond, as_placed;
  const InterpolationChoice* left_out = nullptr;
};

/// Input of a section. asset: as it is; met: as the scene's probe meets it, the same where
/// it is that of the asset. engine: what `met` answered to reference.paths. radius_m: of the
/// probe's round end, about whose centre torques are compared (M58a). floors: of the paths.
/// recorded: null where the reference is simulated; else `scene` says nothing.
struct StatedAsset {
  const runtime::AssetView &asset, &met;
  const Scene& scene;
  const validation::Reference& reference;
  const Replayed& engine;
  double radius_m;
  validation::ErrorFloors floors;
  const ValidateRequest& request;
  double depth_m;  ///< deepest press
  const RecordedReference* recorded = nullptr;
};

/// All sections of the table that are of its kind of reference, in its order; those that say
/// nothing of this asset have no lines.
std::vector<validation::StatementSection> statement_sections(const StatedAsset& of);

/// Reference and answer of every good row that a section is of, as validation.csv.
void write_compared_rows(const std::filesystem::path& path, const StatedAsset& of);

}  // namespace palpate::tools
