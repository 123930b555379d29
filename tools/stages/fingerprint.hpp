#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/io/content_hash.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Hashes of what each stage of `run` reads: program version, the scene's keys that matter to the
/// stage, and the bytes of the files before it. A stage is redone exactly when its hash differs
/// from the one its output carries, so a damaged or edited file is noticed, and its existence
/// proves nothing.
std::string body_inputs(const Scene& scene);
std::string samples_inputs(const Scene& scene, const std::filesystem::path& body);
/// Of what the rows of one test point come from, whichever other points there are: equal hashes
/// mean that a point simulated for one may be used for the other.
std::string point_inputs(const Scene& scene, const Body& body);
std::string curves_inputs(const Scene& scene, const std::filesystem::path& samples);
std::string model_inputs(const std::filesystem::path& curves, const std::filesystem::path& body);
std::string asset_inputs(const Scene& scene, const std::filesystem::path& model);
/// asset_inputs: what the asset was made from; its own bytes change when it gets its statement.
std::string statement_inputs(const Scene& scene, const std::string& asset_inputs,
                             const std::filesystem::path& body);

/// Hash an output carries; nothing when the file is missing, damaged or carries none.
std::optional<std::string> inputs_of_hdf5(const std::filesystem::path& path);
std::optional<std::string> attribute_of_hdf5(const std::filesystem::path& path, const char* name);
std::optional<std::string> inputs_of_asset(const std::filesystem::path& path);
/// Whether an asset carries an error statement in its meta.
bool has_statement(const std::filesystem::path& asset);
std::optional<std::string> inputs_of_json(const std::filesystem::path& path);

inline constexpr const char* kPointInputsAttribute = "point_inputs_hash";

}  // namespace palpate::tools
