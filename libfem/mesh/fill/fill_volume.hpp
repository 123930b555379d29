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
     "TetGen, and CGAL Mesh_3 where TetGen fails or leaves slivers"},
    {Mesher::tetgen, "tetgen", "TetGen 1.5: keeps the surface as given"},
    {Mesher::mesh_3, "mesh_3",
     "CGAL Mesh_3: new surface vertices, takes surfaces that cross themselves"},
}};

struct FillOptions {
  Mesher mesher = Mesher::automatic;
  double target_edge_m = 0;      ///< near the surface; 0: the surface's mean edge
  double interior_growth = 1.6;  ///< interior edge over target_edge_m
  double cpu_limit_s = 15;       ///< of each mesher, and 0.1 ms more per tet that is expected
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

/// Fills a closed surface with tetrahedra, coarse inside, every one positive.
/// closed: manifold, outward; pieces that point inward are cavities. TetGen keeps its triangles as
/// the boundary. Meshers see the body scaled to about 1 m, by a power of two: their tolerances and
/// settings do not know its unit. They run in a child process with a limit of CPU
/// time: their crash is a note in the report or an Error, never the caller's.
/// Throws Error when the surface bounds no volume (`why_not_closed`), when an option is out of
/// range, and when no allowed mesher succeeds, with each one's reason. Deterministic.
TetMesh fill_volume(const Surface& closed, const FillOptions& options = {},
                    FillReport* report = nullptr);

/// Mean length of a triangle's edges.
double mean_edge_m(const Surface& surface);

}  // namespace palpate
