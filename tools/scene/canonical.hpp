#pragma once

#include <string>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Puts into the body what later stages need of a scene: its text with defaults filled in, without
/// [validate], the meshes of the files that it names, and its probe. Returns whether
/// that changed the body.
bool store_scene(const Scene& scene, Body& body);

/// The scene of a body, meshes read. Throws Error at `path` as parse_scene, or where a mesh is
/// missing.
Scene scene_of(const Body& body, const std::filesystem::path& path);

/// Canonical text of all that a stage's result depends on: TOML in SI, in one order. Two scenes
/// with equal text give equal results; comments, key order and spelling of units do not count.
/// Files count by name (their content is the fingerprint's), a mesh that is read by its content.
std::string canonical(const Scene& scene, Stage stage);
std::string canonical(const BodySection& section);
std::string canonical(const FitSection& section);
std::string canonical(const ProbeSpec& probe);
std::string canonical(const ToolSection& tool);

}  // namespace palpate::tools
