#include "libfem/elements/elastic_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpate::fem {
ElasticBody::ElasticBody(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at)
    : mesh_(mesh),
      displacement_rows_(mesh.nodes.rows() / 2 + 1),
      force_rows_(mesh.nodes.rows() / 2 + 1) {
  for (const char is_held : mesh.is_held) free_index_.push_back(is_held ? -1 : free_nodes_++);
  for (const Material& material : materials) {
    const std::size_t number = relaxations_.size();
    relaxations_.push_back(material.relaxation);
    softenings_.push_back(material.softening);
    const std::vector<ElementPoint> points = element_points();
    std::vector<const Material*> material_at(points.size() * kLanes);
    std::vector<std::int32_t> cells;
    for (Eigen::Index c = 0; c < mesh_.tets.rows(); ++c) {
      bool is_here = false;
      for (std::size_t q = 0; q < points.size(); ++q) {
        Vec3 place = Vec3::Zero();
        for (Eigen::Index a = 0; a < kElementNodes; ++a)
          place += points[q].shape[a] * mesh.nodes.row(mesh_.tets(c, a)).transpose();
        const Material* there =
            &materials.at(region_at ? static_cast<std::size_t>(region_at(place)) : 0);
        material_at[points.size() * cells.size() + q] = there;
        is_here |= there == &material;
      }
      if (is_here) cells.push_back(static_cast<std::int32_t>(c));
      if (cells.size() == kLanes)
        add_batch(material, number, points, cells, material_at), cells.clear();
    }
    if (!cells.empty()) add_batch(material, number, points, cells, material_at);
  }
}

void ElasticBody::add_batch(const Material& material, std::size_t number,
                            const std::vector<ElementPoint>& points,
                            const std::vector<std::int32_t>& cells,
                            const std::vector<const Material*>& material_at) {
  Batch batch;
  batch.law = material.law;
  batch.averaged = averaged_share(material);
  batch.shear_modulus_Pa = material.law->small_strain(material.constants).mu_Pa;
  batch.kernels = cell_kernels(Remembers::nothing, set_);
  batch.points.assign(kElementNodes * kLanes, static_cast<std::int32_t>(mesh_.nodes.rows()));
  const int constants = material.law->constants_used;
  batch.gradient = PackArray(kElementPoints * kElementNodes * 3);
  batch.weight = PackArray(kElementPoints);
  batch.constants = PackArray(kElementPoints * constants);
  batch.mode = PackArray(kElementPoints);
  batch.material = number;
  batch.kernels_in_step = kernels_in_step(batch);
  for (int lane = 0; lane < kLanes; ++lane) {
    batch.cell[lane] = lane < static_cast<int>(cells.size()) ? cells[lane] : -1;
    if (batch.cell[lane] < 0) continue;
    for (Eigen::Index a = 0; a < kElementNodes; ++a)
      batch.points[kLanes * a + lane] = mesh_.tets(cells[lane], a);
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(kElementPoints);
    for (int q = 0; q < kElementPoints; ++q) {
      const ElementPoint& point = points[q];
      Mat3 jacobian = Mat3::Zero();  // dX_i/dxi_j
      for (int a = 0; a < kElementNodes; ++a)
        jacobian += mesh_.nodes.row(mesh_.tets(cells[lane], a)).transpose() * point.by_xi.row(a);
      const double det = jacobian.determinant();
      const Eigen::MatrixXd gradient = point.by_xi * jacobian.inverse();
      for (int a = 0; a < kElementNodes; ++a)
        for (int j = 0; j < 3; ++j)
          batch.gradient.at(3 * (kElementNodes * q + a) + j, lane) = gradient(a, j);
      for (int c = 0; c < constants; ++c)
        batch.constants.at(constants * q + c, lane) = material.constants[c];
      if (material_at[kElementPoints * lane + q] != &material) continue;  // weight stays 0
      weight[q] = std::abs(det) * point.weight / 6;
      batch.weight.at(q, lane) = weight[q];
    }
    const Eigen::VectorXd mode = unit_constant(weight);
    for (int q = 0; q < kElementPoints; ++q) batch.mode.at(q, lane) = mode[q];
  }
  batches_.push_back(std::move(batch));
}

// What a material remembers is one thing or the other (refuse_softening).
CellKernels ElasticBody::kernels_in_step(const Batch& batch) const {
  if (relaxations_[batch.material].branches() > 0) return cell_kernels(Remembers::time, set_);
  if (softenings_[batch.material].is_any()) return cell_kernels(Remembers::peak, set_);
  return batch.kernels;
}

void ElasticBody::use(InstructionSet set) {
  set_ = set;
  for (Batch& batch : batches_) {
    batch.kernels = cell_kernels(Remembers::nothing, set);
    batch.kernels_in_step = kernels_in_step(batch);
  }
}

SymmetricBlockMatrix ElasticBody::pattern() const {
  std::vector<std::vector<std::int32_t>> neighbours(free_nodes_);
  for (Eigen::Index c = 0; c < mesh_.tets.rows(); ++c)
    for (Eigen::Index a = 0; a < kElementNodes; ++a)
      for (Eigen::Index b = 0; b < kElementNodes; ++b) {
        const std::int32_t i = free_index_[mesh_.tets(c, a)], j = free_index_[mesh_.tets(c, b)];
        if (i > j && j >= 0) neighbours[j].push_back(i);
      }
  SymmetricBlockMatrix K(neighbours);
  places_.clear();
  for (Eigen::Index c = 0; c < mesh_.tets.rows(); ++c)
    for (Eigen::Index a = 0; a < kElementNodes; ++a)
      for (Eigen::Index b = 0; b <= a; ++b)
        places_.push_back(K.place(free_index_[mesh_.tets(c, a)], free_index_[mesh_.tets(c, b)]));
  return K;
}

// Adds what batches have left in force_rows_.
void ElasticBody::add_force_rows(Points& force) const {
  const double* row = reinterpret_cast<const double*>(force_rows_.data());
  for (Eigen::Index n = 0; n < force.rows(); ++n, row += kPointStride)
    for (int i = 0; i < 3; ++i) force(n, i) += row[i];
}

// Displacements as batches gather them; the last row is zero.
const double* ElasticBody::displacement_rows(const Points& u) const {
  double* rows = reinterpret_cast<double*>(displacement_rows_.data());
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    for (int i = 0; i < 3; ++i) rows[kPointStride * n + i] = u(n, i);
  return rows;
}

template <class Visit>
double ElasticBody::visit_batches(const Points& u, const Visit& visit) const {
  double energy = 0;
  min_J_ = std::numeric_limits<double>::infinity();
  Pack displacement[3 * kElementNodes];
  CellResult result;
  const double* rows = displacement_rows(u);
  std::fill_n(reinterpret_cast<double*>(force_rows_.data()), kPointStride * (u.rows() + 1), 0.0);
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const Batch& batch = batches_[b];
    batch.kernels.gather(rows, batch.points.data(), displacement);
    CellBatch cells{batch.gradient.data(),
                    batch.weight.data(),
                    batch.constants.data(),
                    batch.mode.data(),
                    batch.law->constants_used,
                    batch.averaged,
                    std::numeric_limits<double>::infinity()};
    const CellKernels* kernels = &batch.kernels;
    if (step_) {
      kernels = &batch.kernels_in_step;
      cells.stiffening = step_->stiffening[b];
      cells.held = step_->held[b].data();
      cells.softening = softenings_[batch.material];
      cells.peak = step_->peak[b].data();
    }
    visit(batch, *kernels, cells, batch.law->kernels->with(set_), displacement, result);
    for (int lane = 0; lane < kLanes; ++lane) {
      energy += result.energy[lane];
      min_J_ = std::min(min_J_, result.min_J[lane]);
    }
  }
  return energy;
}

double ElasticBody::energy(const Points& u) const {
  return visit_batches(u, [](const Batch&, const CellKernels& kernels, const CellBatch& cells,
                             const LawKernels& law, const Pack* displacement, CellResult& result) {
    kernels.energy(cells, law, displacement, result);
  });
}

double ElasticBody::add_force(const Points& u, Points& force) const {
  double* rows = reinterpret_cast<double*>(force_rows_.data());
  const double energy =
      visit_batches(u, [&](const Batch& batch, const CellKernels& kernels, const CellBatch& cells,
                           const LawKernels& law, const Pack* displacement, CellResult& result) {
        kernels.force(cells, law, displacement, result);
        kernels.scatter(result.force, batch.points.data(), rows);
      });
  add_force_rows(force);
  return energy;
}

double ElasticBody::add_stiffness(const Points& u, double geometric_scale, Points& force,
                                  SymmetricBlockMatrix& K, double max_pressure) const {
  double* rows = reinterpret_cast<double*>(force_rows_.data());
  const double energy =
      visit_batches(u, [&](const Batch& batch, const CellKernels& kernels, CellBatch cells,
                           const LawKernels& law, const Pack* displacement, CellResult& result) {
        cells.max_pressure_Pa = max_pressure * cells.stiffening * batch.shear_modulus_Pa;
        kernels.stiffness(cells, law, displacement, geometric_scale, result);
        kernels.scatter(result.force, batch.points.data(), rows);
        for (int lane = 0; lane < kLanes; ++lane) {
          if (batch.cell[lane] < 0) continue;
          const BlockPlace* place = places_.data() + kElementBlocks * batch.cell[lane];
          for (int block = 0; block < kElementBlocks; ++block)
            K.add(place[block],
                  reinterpret_cast<const double*>(result.stiffness + 9 * block) + lane, kLanes);
        }
      });
  add_force_rows(force);
  return energy;
}

}  // namespace palpate::fem
