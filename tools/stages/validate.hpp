#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

struct ValidateRequest {
  int jobs = 0;
  std::filesystem::path rows_csv = {};   ///< every compared row; empty for none
  std::filesystem::path reference = {};  ///< folder that keeps what is simulated; empty: none
  bool resume = true;                    ///< use what that folder holds
  const FittedCurves* curves = nullptr;  ///< what the asset was made from, for the baseline
  const Model* model = nullptr;          ///< without interpolation; both or none
};

/// Fresh experiments against the engine, loaded from the asset's bytes (docs/method.md, section 6):
/// held-out paths (draw_held_out) simulated and followed by the engine, the error split by cause,
/// and simpler responses on the same paths.
validation::Statement validate_asset(const std::filesystem::path& asset, const Scene& scene,
                                     const Body& body, const ValidateRequest& request);

/// Recordings of a body: those that were fitted, and those held out of the fit, at other points.
struct RecordedSamples {
  Samples fitted, held_out;
};
/// Where held-out ones are kept beside samples: samples.h5, samples.held_out.h5.
std::filesystem::path held_out_path(std::filesystem::path samples_path);
/// Of a samples.h5 and the file beside it, where there is one.
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

/// A reference with all that was simulated for it, of every kind.
struct SimulatedReference : validation::Reference {
  Samples all;
};

}  // namespace palpate::tools
