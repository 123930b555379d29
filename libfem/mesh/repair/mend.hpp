#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

struct MendOptions {
  bool allow_open = false;  ///< leave borders as they are (no tets can be made then)
  /// When mending fails, wrap the surface instead of refusing it: a new watertight surface around
  /// it that fills every gap narrower than this and lies about a tenth of it outside. Holes are
  /// filled first where they can be; a hollow shell around an open sheet is refused. However far it
  /// moves the surface, it is done, and moved_m says how far.
  std::optional<double> wrap_alpha_m = {};
};

struct Mended {
  Surface surface;
  std::vector<std::string> changes;  ///< a sentence each, in the order they were made
  bool is_wrapped = false;           ///< mending failed, and a wrap was asked for
  double moved_m = 0;                ///< Hausdorff distance, crossing triangles and lids apart
};

/// Largest share of the diagonal: a mending that moves the surface farther changes its form, and is
/// refused; 5 mm of a liver. At half, the liver of which mending moves most (0.8 %) only just
/// passes; at twice, a hollow of 10 mm can go from one. Pits that crossings fill lose 10 % and
/// more.
inline constexpr double kMostMoved = 0.02;

/// A surface that the rest of the program can rely on, from one as it comes.
/// Welds vertices that differ by roundoff (1e-9 of the diagonal: a file of nine digits); drops
/// triangles without area, duplicate triangles, unused vertices, stray pieces and stray facets;
/// splits triangles at T-junctions; separates sheets that touch at an edge or a vertex; orients all
/// outward (cavities inward), and leaves shells out that point outward inside the body; fills
/// holes; removes self-intersections, unless that moves the surface by more than kMostMoved. where:
/// the file, for messages. The result is checked: closed (unless allow_open), manifold,
/// consistently and outwardly oriented, with volume (if closed), free of self-intersections. Throws
/// Error, naming triangles (counted from 1 as in the input) and places in m, when there is no
/// triangle, an index or coordinate is unusable, or the result would fail that check. Same result
/// on every run; seconds for 1e5 triangles. Source of the CGAL steps: Polygon Mesh Processing and
/// 3D Alpha Wrapping, CGAL 5.5.
Mended mend_surface(const Surface& surface, const MendOptions& options, const std::string& where);

}  // namespace palpate
