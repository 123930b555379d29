#pragma once

#include <array>

#include "libfem/mesh/quadratic_mesh.hpp"

namespace palpate::fem {

/// The ring of boundary faces around a contact whose rigid motion is the body's sway there (M33):
/// those that look as the contact point does and lie between kSwayInner and kSwayOuter times the
/// contact's reach from it. Nearer, a dent moves them; farther, another part of the body.
inline constexpr double kSwayInner = 3.5, kSwayOuter = 5.5;

/// How the body moves as a whole around a contact, by force [m/N]: the symmetric matrix, nowhere
/// negative, nearest to the translations at the contact point of the rigid motions that are nearest
/// to the ring's, by area, where unit forces along the axes move the nodes (each N x 3 [m/N]).
/// mesh: in coordinates about the contact point, whose inward unit normal is `normal`. Zero where
/// less than a tenth of a flat ring is there.
Mat3 sway_under(const QuadraticMesh& mesh, const Vec3& normal, double reach_m,
                const std::array<Points, 3>& by_axis);

}  // namespace palpate::fem
