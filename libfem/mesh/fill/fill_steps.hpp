#pragma once

#include <functional>
#include <string>
#include <variant>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Runs a mesher in a forked child that is watched, because meshers crash, abort and loop.
/// Returns its mesh, or why there is none: "stopped on signal 11 (segmentation fault)", or what
/// `mesher` threw: what would come again on any machine. What only this machine at this hour knows
/// must not choose between settings, so it throws Error: the safety limit, no memory, a child that
/// was killed or could not be started. `thrown_int` puts a thrown int into words. The child only
/// calls `mesher`, writes its mesh into anonymous memory and leaves through _exit: no destructor,
/// exit handler or stream of the parent runs twice. Other threads do not exist in the child, which
/// lives no longer than the thread that called; `mesher` must take no lock that one of them may
/// hold (allocation is safe in glibc). Whatever the mesher prints is dropped. safety_limit_s: CPU
/// time of the child, against endless loops; a child that sleeps is killed after 20 times that.
std::variant<TetMesh, std::string> run_in_child(const std::function<TetMesh()>& mesher,
                                                const std::function<std::string(int)>& thrown_int,
                                                double safety_limit_s);

/// Refinement that TetGen is asked for (TetGen 1.5 manual, section 4.2).
struct TetGenSettings {
  double radius_edge_ratio, min_dihedral_deg;
  double max_volume_m3;  ///< of any tet
  int max_added_points;  ///< ends a refinement that would not end
};

/// Fills a closed surface with TetGen 1.5; its triangles become the boundary unchanged. Points in
/// cavities are marked as holes. It may crash, abort or loop: call it in a child process. Throws an
/// int on failure, put into words by `tetgen_failure`, std::bad_alloc, or std::runtime_error where
/// it would add more points than it may.
TetMesh fill_with_tetgen(const Surface& closed, const Points& cavities,
                         const TetGenSettings& settings);
std::string tetgen_failure(int code);

/// Mends tets with a dihedral angle below `below_deg` where they are, worst first: a node goes to a
/// neighbour, an edge or a face gives way to others, an inner edge gets a node. The boundary stays
/// but for edges across which it is flat to 20 degrees and bulges out, which give way, and for
/// nodes and edges next to each other (3 % of an edge). Each change makes the worst angle of what
/// it touches larger and no new sliver, so it ends; a mesh without such tets stays as it is.
/// Returns how many changes were made. Deterministic. After Freitag and Ollivier-Gooch 1997,
/// doi:10.1002/(SICI)1097-0207(19971115)40:21; an edge's removal by dynamic programming after
/// Shewchuk 2002, "Two discrete optimization algorithms for the topological improvement of
/// tetrahedral meshes".
int mend_slivers(TetMesh& mesh, double below_deg);

/// Moves interior nodes so that the smallest dihedral angle around each grows, worst first; nodes
/// on the boundary stay. Never makes the smallest angle around a node smaller. Deterministic. After
/// Freitag and Ollivier-Gooch 1997, doi:10.1002/(SICI)1097-0207(19971115)40:21, with a pattern
/// search in place of their active-set descent.
void smooth_interior(TetMesh& mesh);

/// Pattern search over the axes and their diagonals, from a fifth of an edge down to a hundredth:
/// moves `at` to each place that `accepts`, which remembers what it accepted.
void search_place(Vec3& at, double edge_m, const std::function<bool(const Vec3&)>& accepts);

}  // namespace palpate
