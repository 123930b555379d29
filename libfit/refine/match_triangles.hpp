#pragma once

#include "libfit/core/body.hpp"

namespace palpate {

/// The triangles of the test points, over rows of `position` instead: points are paired by position
/// within 1e-6 of `size_m` (the body's diagonal). position P x 3 [m].
/// Empty when the pairing is not one to one: then the points are not the body's own.
Triangles match_triangles(const Points& position, const TestPoints& points, double size_m);

}  // namespace palpate
