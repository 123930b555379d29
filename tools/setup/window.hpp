#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::tools {

/// A side of a body's bounding box that it could rest on, and the window opposite that a tool
/// presses.
struct Window {
  int axis = 2;       ///< of the held side
  double sign = -1;   ///< of its outward direction
  double held_m = 0;  ///< what lies beyond this coordinate is held
  Vec3 centre = Vec3::Zero();
  double radius_m = 0;

  std::string side() const;
  Vec3 outward() const { return sign * Vec3::Unit(axis); }
};

/// The windows of a closed outward surface, the likeliest first: a side that is flat where it rests
/// (a quarter of the surface is held), and opposite to it much that looks away from it. held: the
/// only side to take; empty: all six.
std::vector<Window> windows_of(const Surface& surface, std::string_view held);

/// Per vertex: in the window's sphere, not held, and on the side that looks away from what is held.
std::vector<char> vertices_in(const Window& window, const Surface& surface);

/// How thick the body is under the window [m]: median over its area, along the inward normals; 0
/// where it has no triangle there.
double thickness_under_m(const Window& window, const Surface& surface);

/// A ball that the window can be pressed with, one radius deep.
struct ProposedBall {
  double radius_m = 0;
  double force_N = 0;  ///< where a press ends, on a half-space (Hertz)
  int reachable = 0;   ///< vertices of the window that it can touch
};

/// Of an eighth of the thickness, 10 mm at most; larger, up to a quarter of it, where half of the
/// rows would be below what a hand feels; and smaller until it reaches most of the window. Nothing
/// where no ball reaches twelve vertices, which test points need, and under a sheet of a 300th of
/// the body's extent. young_Pa, poisson: of the material at rest.
std::optional<ProposedBall> ball_for(const Window& window, const Surface& surface, double young_Pa,
                                     double poisson);

inline constexpr double kFelt_N = 0.04;  ///< that a hand notices

/// Two digits, so that a reader sees a choice and no measurement.
double rounded_m(double length_m);

}  // namespace palpate::tools
