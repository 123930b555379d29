#pragma once

#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

struct SimulationSurfaceOptions {
  /// Share of the fine volume; beyond it a finer target is tried. Grading bends the boundary of
  /// what is filled back onto the fine surface, which is why chords may lose this much volume.
  double volume_tolerance = 0.08;
  double stray_tolerance = 0.3;  ///< of target_edge_m: deviation beyond it, likewise
  /// #V of the fine surface, or empty [m]: how far each of its vertices may be from the coarse one.
  /// Edges near those that are farther are made shorter, round after round.
  Eigen::VectorXd allowed_m = {};
  /// Likewise, how far each is from where a tool presses: a hollow body is coarser away from there.
  Eigen::VectorXd from_region_m = {};
};

/// A coarse surface for the volume mesh, and how true it is.
struct SimulationSurface {
  Surface surface;           ///< closed, manifold, outward, free of self-intersection
  double target_edge_m = 0;  ///< the target that passed; 0 when `surface` is the fine one
  double deviation_m = 0;    ///< largest distance to the fine surface, both directions, sampled
  double excess = 0;         ///< largest distance of a vertex over what it is allowed; 0: not asked
  std::string refused;  ///< why earlier targets were, one sentence; empty when the first passed
};

/// A coarse surface of the body for filling: edges of about `target_edge_m` on flat, thick parts,
/// shorter where curvature or thinness asks, vertices on the fine surface, features kept.
/// fine: closed, manifold, outward. Every result has passed: closed and manifold, not crossing
/// itself, volume and deviation within tolerance. What crosses itself is tried again with shorter
/// edges there, what else fails with a finer target, at last with the fine surface itself.
/// Closeness to allowed_m is sought, not promised: `excess` is what was reached. Throws Error
/// when `fine` bounds no volume, or when even the fine one crosses itself. Deterministic.
SimulationSurface simulation_surface(const Surface& fine, double target_edge_m,
                                     const SimulationSurfaceOptions& options = {});

/// Distance [m] of each vertex of a surface from another surface, #V.
Eigen::VectorXd distances_m(const Surface& of, const Surface& from);

/// Largest distance [m] between two surfaces, in both directions, sampled at vertices, edge
/// midpoints and triangle centres of each: a lower bound of their Hausdorff distance, close to it
/// when the sampled features are no larger than the triangles. boxes_of_a: triangle_boxes(a).
double deviation_m(const Surface& a, const BoxTree& boxes_of_a, const Surface& b);

inline constexpr int kMinTestPoints = 4;
inline constexpr int kMaxTestPoints = 10000;

/// Test points spread evenly over a region of a surface, and their triangulation.
/// in_region: per vertex. The region is made of the triangles whose corners all are in it; it may
/// be closed, have borders, or be several pieces; where two sheets touch in one vertex the
/// smaller sheet's triangles there are left out. Points are vertices of `fine`, in its order,
/// named "p0001"...; normals are inward, from palpate::vertex_normals of `fine`; triangles are
/// outward. Points on a border stay on it, so that the part stays covered. is_reachable: per
/// vertex, where points may stand; they leave other vertices first, and a few may be left there
/// where topology asks for it: the caller looks.
/// The part is decimated by edge length and quadric error, then points slide to even out.
/// As many points as asked, or the nearest number that keeps the topology (no fewer than 3 per open
/// piece, 4 per closed one); all vertices of the part when it has no more than `count`.
/// Throws Error when count is not 4..10000, the flags do not match the vertices, the reachable
/// part has no triangle, or the surface is not manifold there. Deterministic.
TestPoints choose_test_points(const Surface& fine, const std::vector<char>& in_region,
                              const std::vector<char>& is_reachable, int count);

struct FilteredSurface {
  Surface surface;
  double moved_m = 0;      ///< along normals, rms over vertices
  double max_moved_m = 0;  ///< largest distance of a vertex
};

/// Takes noise off the vertices of a scanned or segmented surface and keeps its edges.
/// surface: manifold, triangles that agree; borders move likewise. noise_m > 0: the standard
/// deviation of what is wrong along the normal. Normals of triangles become means over neighbours
/// that lie alike, and vertices follow them (Zheng, Fu, Au and Tai 2011,
/// doi:10.1109/TVCG.2010.264). It ends when vertices have moved by noise_m (rms), the discrepancy
/// principle: more would take off what is no noise. At most 20 rounds. Triangles may come out
/// folded where noise was as large as edges; mend_surface takes such a surface.
FilteredSurface filter_noise(const Surface& surface, double noise_m);

/// Distance of vertices from where their neighbours' neighbours put them, along the normal [m]: the
/// standard deviation of white noise that would do the same, by the median over vertices within
/// smooth patches: neither they nor a neighbour lie on a crease, an edge that turns by more than 40
/// degrees between triangles that each go on smoothly. 0 where no vertex lies so. On a smooth
/// surface it is small against its edges; real ridges of one edge's width count like noise.
double roughness_m(const Surface& surface);

/// Places where a tool touched a body first: position C x 3 [m], inward unit normal C x 3,
/// deviation_m C, of the position along the normal; 0 where it is not known.
struct Contacts {
  Points position{0, 3}, normal{0, 3};
  Eigen::VectorXd deviation_m;
};

/// A surface through contacts.
struct ContactSurface {
  Surface surface;  ///< outward; open where the contacts do not go around the body
  bool is_height_field = false;
  double spacing_m = 0;  ///< median distance of a contact from its nearest neighbour
  double reach = 0;      ///< of the weights around a place, in spacings
  bool uses_normals = false;
  /// C: how far each contact lies outside (+) or inside (-) of the surface that the others make;
  /// NaN where fewer than six are near.
  Eigen::VectorXd left_out_m;
};

/// The surface that contacts lie on. Around a place it is the quadric through the contacts near it
/// by weighted least squares, of their places and, where that predicts contacts left out better,
/// of their normals; how far weights reach is chosen likewise. Where all normals are within 60
/// degrees of their mean and no two contacts are above one another, it is a height field on a mesh
/// of half their spacing, which passes through every contact: the offset of a contact from the
/// quadric fades over half a spacing. Else the contacts are its vertices (advancing front,
/// Cohen-Steiner and Da 2004). Deterministic. Throws Error with fewer than six contacts, or on a
/// line.
ContactSurface surface_from_contacts(const Contacts& contacts);

}  // namespace palpate
