#pragma once

#include <string>
#include <vector>

#include "libfem/probes/reach.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/csv/tables.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// read_scene, with the meshes of its regions and of the probe: what every stage starts from.
Scene open_scene(const std::filesystem::path& path);

/// What a simulation needs of a scene: a [material], and a probe that its table knows and accepts.
/// Throws Error with a remedy.
void check_simulated(const Scene& scene);

/// Turns a surface of one anatomical frame into the frame of the body's file, LPS or RAS, and says
/// so. Throws Error where a frame is neither.
void turn_into_frame_of_body(const std::filesystem::path& body, const std::filesystem::path& file,
                             Surface& surface);

/// "FILE: [body]", where errors of the body are.
std::string body_place(const Scene& scene);

/// The body a scene describes: mended surface, test points on its reachable part and, unless
/// `surface_only`, the filled volume with its held nodes. Says what it finds and mends on stderr.
/// Throws Error, with the scene's place and a remedy, on everything that would make the later
/// stages meaningless; nothing is written here.
/// asset: the surface of an asset. Where it divides the body's triangles otherwise than the scene's
/// tool and depth do, the body takes it.
Body prepare_body(const Scene& scene, bool surface_only, const Surface* asset = nullptr);

/// Checks that need the body: a probe larger than it, a depth larger than it is thick. Throws
/// Error with the scene's key and a remedy.
void check_experiments(const Scene& scene, const Body& body);

/// Errors of points at which the scene's experiments cannot be made, such as a depth beyond the
/// thickness.
std::vector<Error> refused_points(const Scene& scene, const fem::SimulationSetup& setup,
                                  const TestPoints& points);

/// Says that so many of the points, if any, are on parts thinner than the depth.
void say_thin_parts(std::size_t refused, const TestPoints& points);

/// Reads the body's surface, or its volume with its boundary as surface, mends it and filters its
/// noise; says what was changed and keeps it in body.mended. An open surface will do where
/// `surface_only`. Throws Error with a remedy.
void read_meshes(const Scene& scene, bool surface_only, Body& body);

/// Edge of the base volume [m]: mesh_size, or what a body of this volume gets without.
double base_edge_m(const Scene& scene, double volume_m3);

/// Fills the body's closed surface with the base volume, closer to it near in_region where that is
/// filled in, and says its size and quality. Throws Error with a remedy.
void fill_with_tets(const Scene& scene, Body& body);

/// The places of a closed surface that the scene's tool can touch.
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

/// Points a user gave, moved to the nearest place of the surface. Normals are the surface's own
/// (interpolated, inward) unless the table has some. Named "p0001"...
/// Throws Error at `where` with the row of a point farther than 5 % of the body's diagonal: it is
/// another unit or another body.
TestPoints place_points(const PointTable& points, const Surface& surface, const std::string& where);

/// Throws Error where two rows of a table `where` are at one place.
void refuse_same_place(const Points& position, const std::string& where);

/// The same as place_points() for tool paths; deflections stay as they are. normal: inward, one row
/// per path.
struct PlacedPaths {
  TestPoints points;
  std::vector<ToolPath> paths;  ///< one per point
};
PlacedPaths place_paths(const std::vector<PathInTable>& paths, const Surface& surface,
                        const std::string& where);

/// The simulator's input from a scene: body, material, inclusions, beds and probe.
fem::SimulationSetup make_setup(const Scene& scene, const Body& body);

/// The test point in the middle of the window.
Eigen::Index middle_point(const Scene& scene, const Body& body);

/// Lists the parts that are not of [material], layers first; at a place the last one counts.
std::vector<InclusionSection> parts_of_body(const Scene& scene, const Body& body);

/// The presses and drags that the scene makes at each of its test points.
fem::Experiments experiments_of(const Scene& scene);

/// What a scene says that no tissue, tool or body is like, one sentence each with the likely slip:
/// a modulus read in the wrong unit, a probe or a body of the wrong size, too much friction.
std::vector<std::string> implausible(const Scene& scene, const Body& body);

/// The same of the body's shape alone, without its material: an unlikely size, separate parts, a
/// tetmesh that is cut where its nodes are doubled.
std::vector<std::string> doubts_of_shape(const Scene& scene, const Body& body);

/// Place of an inclusion. inside: share of its volume in the body; NaN for half-spaces.
struct InclusionPlace {
  double volume_m3 = 0;  ///< inside the body
  double inside = 0;
  double depth_m = 0;     ///< least distance between its border and the surface; 0: cut by it
  Eigen::Index tets = 0;  ///< of the base mesh, by their centres
};

/// One for each of the scene's inclusions, from some 20,000 samples of its box. Throws Error where
/// none of an inclusion is inside the body.
std::vector<InclusionPlace> place_inclusions(const Scene& scene, const Body& body);

/// "194 x 154 x 156 mm, 1.48 l": so that a wrong unit is seen. Volume left out when 0.
std::string size_in_words(const Vec3& extent_m, double volume_m3);

/// "(-1.0, 0.0, 20.3) mm".
std::string in_mm(const Vec3& place_m);

/// "x -1.0 to 20.0, y 0.0 to 3.0, z 0.0 to 30.0 mm": where nodes lie.
std::string span_in_words(const Points& nodes);

/// Says what is implausible and where inclusions lie on stderr.
void say_plausibility(const Scene& scene, const Body& body);

}  // namespace palpate::tools
