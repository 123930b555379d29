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
  ValidateSection settings;
  int jobs = 0;
  std::filesystem::path rows_csv;        ///< every compared row; empty for none
  std::filesystem::path reference;       ///< folder that keeps what is simulated; empty: none
  bool resume = true;                    ///< use what that folder holds
  const FittedCurves* curves = nullptr;  ///< what the asset was made from, for the baseline
  const Model* model = nullptr;          ///< without interpolation; both or none
};

/// Fresh experiments against the engine, loaded from the asset's bytes (docs/method.md, section 6):
/// held-out paths (draw_held_out) simulated and followed by the engine, the error split by cause,
/// and simpler responses on the same paths.
validation::Statement validate_asset(const std::filesystem::path& asset, const Scene& scene,
                                     const Body& body, const ValidateRequest& request);

/// The same, written: the asset carries its statement from then on, and statement.json has the hash
/// of what it was made from. body_file: body.h5 of the body.
validation::Statement state_asset(const std::filesystem::path& asset, const Scene& scene,
                                  const Body& body, const ValidateRequest& request,
                                  const std::filesystem::path& body_file,
                                  const std::filesystem::path& statement_json);

/// Writes a statement into the asset and, with the hash of what it was made from, statement.json.
validation::Statement store_statement(const std::filesystem::path& asset,
                                      validation::Statement statement, const std::string& inputs,
                                      const std::filesystem::path& statement_json);

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

/// The same, written as state_asset() does. samples_file: samples.h5.
validation::Statement state_recordings(const std::filesystem::path& asset,
                                       const std::filesystem::path& samples_file,
                                       const ValidateRequest& request, const Body* body,
                                       const std::filesystem::path& statement_json);

struct ReferenceRequest {
  ValidateSection settings;
  int jobs = 0;
  /// Folder in which what is simulated is kept and looked for; empty: nowhere.
  std::filesystem::path folder;
  std::string fingerprint;  ///< point_fingerprint of the scene and the body
  bool resume = true;
};

/// Draws the held-out experiments of a scene and simulates them, but for those that the folder's
/// `reference.h5` holds already. An interruption (exception Interrupted) keeps what is done.
validation::Reference simulate_reference(const Scene& scene, const Body& body,
                                         const ReferenceRequest& request);

}  // namespace palpate::tools
