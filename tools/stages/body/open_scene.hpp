#pragma once

#include <filesystem>
#include <string>

#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// read_scene, with the meshes of its regions and of the probe: what every stage starts from.
Scene open_scene(const std::filesystem::path& path);

/// What a simulation needs of a scene: a [material], and a probe that its table knows and accepts.
/// Throws Error with a remedy.
void check_simulated(const Scene& scene);

/// "FILE: [body]", where errors of the body are.
std::string body_place(const Scene& scene);

}  // namespace palpate::tools
