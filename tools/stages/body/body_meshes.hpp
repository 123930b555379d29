#pragma once

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Reads the body's surface, or its volume with its boundary as surface, mends it and filters its
/// noise; says what was changed and keeps it in body.mended. An open surface will do where
/// `surface_only`. Throws Error with a remedy.
void read_meshes(const Scene& scene, bool surface_only, Body& body);

/// Edge of the base volume [m]: mesh_size, or what a body of this volume gets without.
double base_edge_m(const Scene& scene, double volume_m3);

/// Fills the body's closed surface with the base volume, closer to it near in_region where that is
/// filled in, and says its size and quality. Throws Error with a remedy.
void fill_with_tets(const Scene& scene, Body& body);

}  // namespace palpate::tools
