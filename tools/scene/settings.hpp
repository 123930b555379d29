#pragma once

#include <string>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The settings that later stages need, as body.h5 stores them: [body], [material], [[inclusion]],
/// [experiments] and [fit], defaults filled in, SI. Files by name alone.
Settings settings_of(const Scene& scene);

/// The scene of a body: its settings and its probe, mesh read. Throws Error at `path` naming the
/// setting that is missing or of the wrong kind.
Scene scene_of(const Body& body, const std::filesystem::path& path);

/// Canonical text of all that a stage's result depends on: its settings by key, in one order. Two
/// scenes with equal text give equal results; comments, key order and spelling of units do not
/// count. Files count by name (their content is the fingerprint's), a probe's mesh by its numbers.
std::string canonical(const Scene& scene, Stage stage);
std::string canonical(const BodySection& section);
std::string canonical(const FitSection& section);
std::string canonical(const ExportSection& section);
std::string canonical(const Settings& settings);
std::string canonical(const ProbeSpec& probe);
std::string canonical(const ToolSection& tool);

}  // namespace palpate::tools
