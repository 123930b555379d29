#pragma once

#include <functional>
#include <vector>

#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/elastic_bed.hpp"

namespace palpate::fem {

/// Linear response of a body at rest to a unit force along `normal` (inward, unit) on a patch
/// of its surface. The force is spread as Hertz's pressure over faces within `radius_m` of the
/// origin that look against `normal`; compliance_m_N is the mean of the displacement, weighted
/// alike, under a unit force along each axis (a column each). distortion_J_N2: #base tets, the
/// deviatoric energy of their parts by the displacements of corners. sway_m_N: how the body moves
/// as a whole around the patch under a unit force along each axis (M33), symmetric and nowhere
/// negative; zero where that is not told. Zero and empty where no face is met or the body has no
/// stiffness.
struct PatchResponse {
  Mat3 compliance_m_N = Mat3::Zero();
  std::vector<double> distortion_J_N2;
  Mat3 sway_m_N = Mat3::Zero();
};

/// One factorization. The mesh knows its base tets (QuadraticMesh::base), `base_tets` of them.
PatchResponse press_patch(const QuadraticMesh& mesh, std::size_t base_tets,
                          const std::vector<Material>& materials, const RegionAt& region_at,
                          const Vec3& normal, double radius_m, const BedAt& bed_at = {});

/// Which tets of the base mesh to halve for a contact, and which share of force may be wrong after
/// that because of the base mesh: thickness, far geometry, the border of what is held.
/// halved: #base tets, or empty for none.
struct BaseRefinement {
  std::vector<char> halved;
  double error = 0;
  Mat3 sway_m_N = Mat3::Zero();  ///< of PatchResponse, on the finer mesh
};

/// The patch response on the mesh graded for the contact, its elements `coarsening` times as large
/// as the contact asks for, with these base tets halved.
using PressPatch = std::function<PatchResponse(double coarsening, const std::vector<char>& halved)>;

/// Which base tets to halve so that no more than about `max_error` of force, relative and sideways
/// too, is wrong because of the base mesh: those that hold two thirds of the distortion under
/// the patch, or none (M13d). The forces that move the patch along `normal`, sticking and sliding,
/// are compared with whole and with halved tets, on the grid whose elements are `coarse_ratio`
/// times as large; where that cannot tell, as its own error changes with the tets too, on both
/// grids, extrapolated.
BaseRefinement refine_base(const PressPatch& press, double coarse_ratio, const Vec3& normal,
                           double max_error);

}  // namespace palpate::fem
