#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

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
