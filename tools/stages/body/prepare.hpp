#pragma once

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The body a scene describes: mended surface, test points on its reachable part and, unless
/// `surface_only`, the filled volume with its held nodes. Says what it finds and mends on stderr.
/// Throws Error, with the scene's place and a remedy, on everything that would make the later
/// stages meaningless; nothing is written here.
/// asset: the surface of an asset. Where it divides the body's triangles otherwise than the scene's
/// tool and depth do, the body takes it.
Body prepare_body(const Scene& scene, bool surface_only, const Surface* asset = nullptr);

/// What only the body can tell: a probe larger than it, a depth larger than it is thick. Throws
/// Error with the scene's key and a remedy.
void check_experiments(const Scene& scene, const Body& body);

}  // namespace palpate::tools
