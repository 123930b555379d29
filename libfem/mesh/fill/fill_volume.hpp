#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

enum class Mesher : int { automatic = 0, tetgen = 1, mesh_3 = 2 };

struct MesherName {
  Mesher mesher;
  std::string_view name;
  std::string_view summary;
};
inline constexpr std::array<MesherName, 3> kMeshers{{
    {Mesher::automatic, "automatic",
     "TetGen, and CGAL Mesh_3 where TetGen fails or leaves one sliver in a hundred tets"},
    {Mesher::tetgen, "tetgen", "TetGen 1.5: keeps the surface as given"},
    {Mesher::mesh_3, "mesh_3",
     "CGAL Mesh_3: new surface vertices, takes surfaces that cross themselves"},
}};

struct FillOptions {
  Mesher mesher = Mesher::automatic;
  double target_edge_m = 0;      ///< near the surface; 0: the surface's mean edge
  double interior_growth = 1.6;  ///< interior edge over target_edge_m
  int max_nodes = 200'000;       ///< a mesher that wants more has failed; grading takes no more
  double safety_limit_s = 3600;  ///< CPU time of a mesher's run, against endless loops: an Error
};

/// How a filling went.
struct FillReport {
  Mesher mesher = Mesher::automatic;  ///< the one that made the mesh: tetgen or mesh_3
  int nodes = 0, tets = 0;
  double min_dihedral_deg = 0;
  double worst_mean_ratio = 0;     ///< 1 for a regular tet, 0 for a flat one
  int slivers = 0;                 ///< tets with a dihedral angle below 5 degrees
  double volume_ratio = 0;         ///< of the tets over the surface's
  std::vector<std::string> notes;  ///< what failed on the way, a sentence each
};

/// Tets that an edge length asks for: of a body's surface, whose edges come out at some 0.6 of it
/// where it is curved or thin, and of what is inside. Within a factor of two for
/// the meshes that `fill_volume` makes of simulation surfaces, at edges of 0.1 to 0.28 V^(1/3).
double expected_tets(double volume_m3, double area_m2, double edge_m, double interior_growth = 1.6);

/// Fills a closed surface with tetrahedra, coarse inside, every one positive.
/// closed: manifold, outward; pieces that point inward are cavities. TetGen keeps its triangles as
/// the boundary, but for edges that turn by less than 20 degrees and give way to mend a sliver.
/// TetGen's mesh is taken unless it has none or more than one sliver in a hundred tets after
/// mending (mend_slivers.hpp); then Mesh_3's, unless that one has as many or more. Nothing depends
/// on time. Meshers see the body scaled to about 1 m, by a power of two: their tolerances and
/// settings do not know its unit. They run in a child process: their crash is a note in the report
/// or an Error, never the caller's.
/// Throws Error when the surface bounds no volume (`why_not_closed`), when an option is out of
/// range, when no allowed mesher succeeds, with each one's reason, and when a mesher reaches its
/// safety limit or finds no memory. Deterministic.
TetMesh fill_volume(const Surface& closed, const FillOptions& options = {},
                    FillReport* report = nullptr);

/// Mean length of a triangle's edges.
double mean_edge_m(const Surface& surface);

}  // namespace palpate
