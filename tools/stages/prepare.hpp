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

}  // namespace palpate::tools
