#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Tets that an edge length asks for: of a body's surface, whose edges come out at some 0.6 of it
/// where it is curved or thin, and of what is inside. Within a factor of two for
/// the meshes that `fill_volume` makes of simulation surfaces, at edges of 0.1 to 0.28 V^(1/3).
double expected_tets(double volume_m3, double area_m2, double edge_m);

/// Fills a closed surface with tetrahedra, coarse inside, every one positive.
/// closed: manifold, outward, not crossing itself; pieces that point inward are cavities. edge_m >
/// 0: near the surface; inside edges are 1.6 times as long. TetGen keeps the surface's triangles as
/// the boundary, but for edges that turn by less than 20 degrees and go to mend a sliver
/// (fill_steps.hpp). It sees the body scaled to about 1 m, by a power of two: its tolerances and
/// settings do not know its unit. It runs in a child process: its crash is an Error, never the
/// caller's. Nothing depends on time. Throws Error when TetGen fails or wants more than 200,000
/// points inside, and when it reaches its safety limit of an hour of CPU time or finds no memory.
/// Deterministic.
TetMesh fill_volume(const Surface& closed, double edge_m);

}  // namespace palpate
