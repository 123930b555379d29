#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A hollow body: its surface, outward, and the lumens in it, whose triangles look into them.
struct Walled {
  Surface surface;
  int lumens = 0;
  double lumen_m3 = 0;
  double thickness_m = 0;  ///< distance of the outer surface from a lumen, its median over area
  double solid_share = 0;  ///< of the outer surface: what is twice as far from every lumen
};

/// The body between a closed surface, outward, and the surface that lies wall_m [m] inside it,
/// solid where it is thinner than two walls: the lumens are what lies deeper than wall_m, wrapped
/// from within by edges of 0.65 walls, so that narrower passages are closed. No lumen where
/// nothing lies so deep. Throws Error where wall_m is not positive. O(V / wall_m^3 log T) for a
/// body of volume V.
Walled with_wall(const Surface& outer, double wall_m);

/// True where that has a lumen, in a part of the time.
bool leaves_lumen(const Surface& outer, double wall_m);

/// The same with a closed surface as the lumen. Throws Error where a vertex of it is not inside
/// `outer`. where: the file of the lumen, for messages.
Walled with_lumen(const Surface& outer, Surface lumen, const std::string& where);

}  // namespace palpate
