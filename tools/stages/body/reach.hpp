#pragma once

#include "libfem/probes/reach.hpp"
#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What the scene's tool can touch of a closed surface.
fem::ToolReach make_reach(const Scene& scene, const Surface& surface);

/// Fills in_region of a body that has its surface, where the scene's regions speak of it: what the
/// scene's region holds and is not fixed.
void find_region(const Scene& scene, Body& body);

/// Divides triangles of the region that are far off the smooth surface, which the simulator's tool
/// meets, for the engine's contact point slides on triangles; finds the region anew. Says what is
/// divided. After filling: a smooth surface may cross itself where the given one does not.
void divide_region(const Scene& scene, Body& body);

/// Fills is_reachable: what of in_region the tool can touch, or all of it where `surface_only`
/// (recorded points were touched). Patches smaller than a contact do not count, and what lies
/// farther than the tool's half width, and than half of what test points lie apart, from all that
/// can be touched leaves the region; narrower gaps stay in it, so that curves are blended across.
/// Says what is left out. Throws Error when fewer than three vertices are left.
void find_reachable(const Scene& scene, bool surface_only, Body& body);

/// choose_test_points on a body whose flags are there. A gap that a point would have to stand in
/// leaves the region.
TestPoints spread_test_points(Body& body, int count);

/// Takes given test points out where the tool cannot touch, and lists them. Throws Error when none
/// stays.
void leave_out_of_reach(const Scene& scene, Body& body);

}  // namespace palpate::tools
