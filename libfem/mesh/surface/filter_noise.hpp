#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

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

}  // namespace palpate
