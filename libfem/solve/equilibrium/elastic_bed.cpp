#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {

ElasticBed::ElasticBed(const QuadraticMesh& mesh, const BedAt& bed_at) {
  if (!bed_at) return;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    BedFace face;
    for (int a = 0; a < kFaceNodes; ++a) face.node[a] = mesh.faces(f, a);
    const FaceNodes nodes = nodes_of_face(mesh.nodes, face.node);
    face.block.fill(Mat3::Zero());
    bool has_bed = false;
    for (const FacePoint& point : kFaceRule) {
      const BedStiffness bed = bed_at(place_at(point, nodes));
      if (bed.along_N_m3 == 0 && bed.across_N_m3 == 0) continue;
      has_bed = true;
      const Vec3 area = area_normal_at(point, nodes);
      const Vec3 normal = area.normalized();
      const Mat3 stiffness = point.weight * area.norm() *
                             ((bed.along_N_m3 - bed.across_N_m3) * normal * normal.transpose() +
                              bed.across_N_m3 * Mat3::Identity());  // (M13f)
      for (int a = 0, pair = 0; a < kFaceNodes; ++a)
        for (int b = 0; b <= a; ++b, ++pair)
          face.block[pair] += point.shape[a] * point.shape[b] * stiffness;
    }
    if (has_bed) faces_.push_back(face);
  }
}

double ElasticBed::add_force(const Points& u, Points& force) const {
  double energy = 0;
  for (const BedFace& face : faces_)
    for (int a = 0, pair = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b, ++pair) {
        const Vec3 at_a = u.row(face.node[a]), at_b = u.row(face.node[b]);
        const Vec3 pull = face.block[pair] * at_b;
        force.row(face.node[a]) += pull;
        energy += (a == b ? 0.5 : 1.0) * at_a.dot(pull);
        if (a != b) force.row(face.node[b]) += face.block[pair] * at_a;
      }
  return energy;
}

void ElasticBed::add_stiffness(const std::vector<std::int32_t>& free_index,
                               SymmetricBlockMatrix& K) const {
  for (const BedFace& face : faces_)
    for (int a = 0, pair = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b, ++pair) {
        const std::int32_t i = free_index[face.node[a]], j = free_index[face.node[b]];
        // A block is symmetric, so it need not be turned.
        if (i >= 0 && j >= 0) K.add(K.place(i, j), face.block[pair].data());
      }
}

}  // namespace palpate::fem
