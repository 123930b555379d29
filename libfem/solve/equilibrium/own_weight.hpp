#pragma once

#include <vector>

#include "libfem/elements/elements.hpp"
#include "libfem/materials/materials.hpp"
#include "libfem/mesh/quadratic_mesh.hpp"
#include "libfem/solve/equilibrium/elastic_bed.hpp"

namespace palpate::fem {

/// What a body weighs.
struct OwnWeight {
  Vec3 acceleration_m_s2 = Vec3::Zero();
  double density_kg_m3 = 0;  ///< at rest; 0: no weight

  bool is_there() const { return density_kg_m3 > 0; }
};

/// What is bent by its weight: the parts of an Equilibrium without a probe.
struct WeightedBody {
  const std::vector<Material>& materials;
  RegionAt region_at = {};
  BedAt bed_at = {};
  const OwnWeight& weight;
  bool regions_at_rest = false;  ///< region_at and bed_at speak of the shape at rest
};

/// Forces of the weight at the nodes, #N x 3 [N]: rho g int N dV over the body at rest (M13h). Mass
/// stays, so they do not depend on the displacement. Zeros of no rows without weight.
Points weight_N(const QuadraticMesh& mesh, const OwnWeight& weight);

/// How a search for the loaded shape or the shape at rest ended.
struct LoadedSearch {
  double share = 0;       ///< of the weight that was carried; 1: found
  double residual_m = 0;  ///< largest distance of a node from where the given shape has it
  int solves = 0;         ///< with a factor
  bool is_found() const { return share == 1; }
};

/// Fills mesh.loaded: where the nodes are once the body at rest carries its weight (Newton's method
/// with load steps). Without is_found() the mesh is as it was.
LoadedSearch bend_under_weight(const WeightedBody& body, QuadraticMesh& mesh);

/// Takes the nodes of the mesh for the shape under load, finds the shape at rest that bends into it
/// and puts it in their place; mesh.loaded is the equilibrium, within residual_m <= tolerance_m of
/// the nodes that were given (M13i). sag: #N x 3 [m], a guess of what the weight moves the nodes
/// by, or no rows. Without is_found() the mesh is as it was.
/// Source: Sellier 2011, doi:10.3970/cmes.2011.073.219 (backward displacement), with Anderson
/// mixing.
LoadedSearch unbend(const WeightedBody& body, double tolerance_m, const Points& sag,
                    QuadraticMesh& mesh);

}  // namespace palpate::fem
