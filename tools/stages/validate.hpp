#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/refine/interpolation.hpp"
#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

struct ValidateRequest {
  int jobs = 0;
  std::filesystem::path rows_csv = {};   ///< every compared row; empty for none
  std::filesystem::path reference = {};  ///< folder that keeps what is simulated; empty: none
  bool resume = true;                    ///< use what that folder holds
  const FittedCurves* curves = nullptr;  ///< of recordings: what points left out are judged by
};

/// Fresh experiments against the engine, loaded from the asset's bytes (docs/method.md, section 6):
/// held-out paths (draw_held_out) simulated and followed by the engine, the error split by cause,
/// and simpler responses on the same paths.
validation::Statement validate_asset(const std::filesystem::path& asset, const Scene& scene,
                                     const Body& body, const ValidateRequest& request);

/// Interval of the body's own forces about its asset's, by the deviations that the scene states.
/// replay_p95_rel: of the statement; 0 before there is one.
std::optional<validation::TruthInterval> interval_of(const Scene& scene, double held_share,
                                                     double replay_p95_rel = 0);

/// Recordings of a body: those that were fitted, and those held out of the fit, at other points.
struct RecordedSamples {
  Samples fitted, held_out;
};
/// Name under which held-out ones are kept beside samples: samples.h5, samples.held_out.h5.
std::filesystem::path held_out_path(std::filesystem::path samples_path);
/// Reads a samples.h5 and the file beside it, where there is one.
RecordedSamples read_recorded(const std::filesystem::path& samples_path);

/// An asset that was made of recordings against those held out of the fit (docs/measured-data.md,
/// "Error statement"): the engine follows them from the asset's bytes. Beside it what the recorded
/// presses nearby say, what the fitted points say of each other (where the request has the curves,
/// and `body`), and what the asset was fitted to. Throws Error where the asset has another probe
/// than the samples.
validation::Statement validate_recordings(const std::filesystem::path& asset,
                                          const RecordedSamples& samples,
                                          const ValidateRequest& request,
                                          const Body* body = nullptr);

/// Recordings of the asset's body: those that it was fitted to, and those held out of the fit at
/// places where it has no curves of its own. Held-out ones at all others are reference.paths, moved
/// onto the asset's surface; as_placed: the same where they were recorded.
/// left_out: what refine() found by leaving points out of the request's curves; null: not known.
struct RecordedReference {
  Samples fitted, beyond, as_placed;
  const InterpolationChoice* left_out = nullptr;
};

/// Held-out paths: those where the body changes (draw_sliding), or those drawn all over it.
Samples paths_of(const Samples& reference, bool are_where_it_changes);

/// Input of a section. asset: as it is; met: as the scene's probe meets it, the same where
/// it is that of the asset. engine: what `met` answered to reference.paths. levers: where
/// torques of the probe are compared (M58a). floors: of the paths.
/// recorded: null where the reference is simulated; else `scene` says nothing.
struct StatedAsset {
  const runtime::AssetView &asset, &met;
  const Scene& scene;
  const validation::Reference& reference;
  const Replayed& engine;
  std::optional<validation::Levers> levers;
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
