#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The beginning of the fingerprint of what a stage reads: its name and the program (its version in
/// a release, its sources in a developer's build). To it go the scene's settings that matter to the
/// stage, and the content of what was made before. A stage is redone exactly when the fingerprint
/// wanted differs from the one stored in its output, so a damaged or edited file is noticed, and
/// its existence proves nothing.
ContentHash stage_hash(const char* stage);
std::string body_fingerprint(const Scene& scene);
/// Of the program alone.
std::string import_fingerprint();
/// Of all samples; those of the body's test points or of the points that are placed from them on.
std::string samples_fingerprint(const Scene& scene, const Body& body);
/// Of the rows of one test point, whichever other points there are: where it is equal, a point
/// simulated for one file may be used for another.
std::string point_fingerprint(const Scene& scene, const Body& body);
/// The same of rows that the scene's [tool] made and others beside [probe]; empty without any.
std::string tool_fingerprint(const Scene& scene, const std::vector<ToolSection>& others);
/// Fingerprint stored in a file; nothing when the file is missing, damaged or has none.
std::optional<std::string> stored_in_hdf5(const std::filesystem::path& path,
                                          const char* attribute = kInputsAttribute);
/// The same of an asset, in its meta, and of a statement.
std::optional<std::string> stored_in_json(const std::filesystem::path& path);
/// True if an asset carries an error statement in its meta.
bool has_statement(const std::filesystem::path& asset);

/// The attributes under which samples carry their point_fingerprint and tool_fingerprint.
inline constexpr const char* kPointFingerprintAttribute = "point_inputs_hash";
inline constexpr const char* kToolFingerprintAttribute = "tool_inputs_hash";

}  // namespace palpate::tools
