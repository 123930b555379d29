#pragma once

#include <array>
#include <functional>
#include <vector>

#include "libfem/contact/face_rule.hpp"
#include "libfem/elements/block_matrix.hpp"
#include "libfem/mesh/quadratic_mesh.hpp"

namespace palpate::fem {

/// What a place of a body's boundary rests on: force over area and displacement [N/m^3], along the
/// normal and across it.
struct BedStiffness {
  double along_N_m3 = 0, across_N_m3 = 0;
};

/// The bed under a place [m] of the boundary at rest; zeros where there is none. May be empty.
using BedAt = std::function<BedStiffness(const Vec3& rest_position)>;

/// Springs on a body's boundary (Winkler's foundation), linear in the displacement:
/// E = 1/2 int u . k u dA, k = along n n' + across (1 - n n'), n and A of the boundary at rest
/// (M13f). It pulls as it pushes. Integrated with six points a face, so its border may cross one.
class ElasticBed {
 public:
  ElasticBed() = default;
  ElasticBed(const QuadraticMesh& mesh, const BedAt& bed_at);

  bool is_empty() const { return faces_.empty(); }

  /// Energy [J] at displacement u (#N x 3 [m]) and, added to force (#N x 3 [N]), its gradient.
  double add_force(const Points& u, Points& force) const;

  /// Added to K, which couples the nodes of each face; free_index: #N, -1 for held nodes.
  void add_stiffness(const std::vector<std::int32_t>& free_index, SymmetricBlockMatrix& K) const;

 private:
  struct BedFace {
    std::array<std::int32_t, kFaceNodes> node;
    std::array<Mat3, kFaceBlocks> block;  // pairs a >= b
  };
  std::vector<BedFace> faces_;
};

}  // namespace palpate::fem
