#pragma once

#include <array>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/elements/block_matrix.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

/// A constant pressure in the lumens of a body: the parts of its boundary that enclose a void. It
/// follows the lumens as they deform, with the potential E = -p V of their volume (M13l), V = -1/3
/// int x . dA over the faces, which point into them. Source: Bufler 1984,
/// Pressure loaded structures under large deformations, Z. Angew. Math. Mech. 64.
class LumenPressure {
 public:
  LumenPressure() = default;
  /// The mesh must outlive this. No faces where the pressure is zero.
  LumenPressure(const QuadraticMesh& mesh, double pressure_Pa);

  bool is_empty() const { return faces_.empty(); }

  /// Energy [J] at displacement u (#N x 3 [m]) and, added to force (#N x 3 [N]), its gradient.
  double add_force(const Points& u, Points& force) const;

  /// Its Hessian, added to K, which couples the nodes of each face; free_index: #N, -1 for held
  /// nodes.
  void add_stiffness(const Points& u, const std::vector<std::int32_t>& free_index,
                     SymmetricBlockMatrix& K) const;

 private:
  const QuadraticMesh* mesh_ = nullptr;
  double pressure_Pa_ = 0;
  std::vector<std::array<std::int32_t, kFaceNodes>> faces_;
};

}  // namespace palpate::fem
