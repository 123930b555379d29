#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The body a scene describes: mended surface, test points on its reachable part and, unless
/// `surface_only`, the filled volume with its held nodes. Says what it finds and mends on stderr.
/// Throws Error, with the scene's place and a remedy, on everything that would make the later
/// stages meaningless; nothing is written here.
Body prepare_body(const Scene& scene, bool surface_only);

/// read_scene, the probe's mesh read as well: what every stage starts from.
Scene open_scene(const std::filesystem::path& path);

/// "194 x 154 x 156 mm, 1.48 l": so that a wrong unit is seen. Volume left out when 0.
std::string size_in_words(const Vec3& extent_m, double volume_m3);

/// What a simulation needs of a scene: a [material], and a probe that its table knows and accepts.
/// Throws Error with a remedy.
void check_choices(const Scene& scene);

/// What only the body can tell: a probe larger than it, a depth larger than it is thick. Throws
/// Error with the scene's key and a remedy.
void check_experiments(const Scene& scene, const Body& body);

}  // namespace palpate::tools
