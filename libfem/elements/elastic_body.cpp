#include "libfem/elements/elastic_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libfem/mesh/topology.hpp"

namespace palpate::fem {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// All of U(J) but what leaves lambda = `kept` mu at each point.
double share_beyond(const Material& material, double kept) {
  double U, U1, U2;
  material.law->volumetric(material.constants, 0, U, U1, U2);
  const SmallStrain hooke = material.law->small_strain(material.constants);
  const double beyond_Pa = hooke.lambda_Pa - kept * hooke.mu_Pa;
  return beyond_Pa > 0 ? std::min(1.0, beyond_Pa / U2) : 0;
}

}  // namespace

double averaged_share(const Material& material) { return share_beyond(material, 1); }

ElementPoint element_point(const Eigen::Vector4d& L, double weight) {
  constexpr double dL[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // dL_c/dxi_j
  ElementPoint point{L, weight, Eigen::VectorXd(kElementNodes), {}};
  point.by_xi.resize(kElementNodes, 3);
  for (int c = 0; c < 4; ++c) {
    point.shape[c] = L[c] * (2 * L[c] - 1);
    for (int j = 0; j < 3; ++j) point.by_xi(c, j) = (4 * L[c] - 1) * dL[c][j];
  }
  for (int e = 0; e < 6; ++e) {
    const int a = kTetEdge[e][0], b = kTetEdge[e][1];
    point.shape[4 + e] = 4 * L[a] * L[b];
    for (int j = 0; j < 3; ++j) point.by_xi(4 + e, j) = 4 * (L[a] * dL[b][j] + L[b] * dL[a][j]);
  }
  return point;
}

std::vector<ElementPoint> element_points() {
  const double far = 0.138196601125010515;  // barycentric, of the three farther corners
  std::vector<ElementPoint> out;
  for (int c = 0; c < kElementPoints; ++c) {
    Eigen::Vector4d L = Eigen::Vector4d::Constant(far);
    L[c] = 1 - 3 * far;
    out.push_back(element_point(L, 0.25));
  }
  return out;
}

Eigen::VectorXd unit_constant(const Eigen::VectorXd& weight) {
  const double sum = weight.sum();
  if (!(sum > 0)) return Eigen::VectorXd::Zero(weight.size());
  return (weight.array() != 0).cast<double>() / std::sqrt(sum);
}

ElasticBody::ElasticBody(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at)
    : mesh_(mesh),
      displacement_rows_(mesh.nodes.rows() / 2 + 1),
      force_rows_(mesh.nodes.rows() / 2 + 1) {
  for (const char is_held : mesh.is_held) free_index_.push_back(is_held ? -1 : free_nodes_++);
  std::vector<char> is_on_boundary(mesh.nodes.rows(), 0);
  for (const std::int32_t n : mesh.faces.reshaped()) is_on_boundary[n] = 1;
  const std::vector<ElementPoint> points = element_points();
  std::vector<const Material*> filling;  // each point of each tet, asked for once
  for (const auto& tet : mesh.tets.rowwise())
    for (const ElementPoint& point : points) {
      Vec3 place = Vec3::Zero();
      for (Eigen::Index a = 0; a < kElementNodes; ++a)
        place += point.shape[a] * mesh.nodes.row(tet[a]).transpose();
      filling.push_back(&materials.at(region_at ? region_at(place) : 0));
    }
  for (const Material& material : materials) {
    const std::size_t number = relaxations_.size();
    relaxations_.push_back(material.relaxation);
    softenings_.push_back(material.softening);
    // A mean over an element does not see how volume changes through a wall that bends. Errors of
    // walls one element thick, edges of 1.25 to 2.5 thicknesses, at nu 0.45 and 0.49: with 1 mu 11
    // to 14 %, with 4 mu -2 to 3.5 %, with 9 mu -10 to -1 % (elasticity_test).
    const double shares[] = {averaged_share(material), share_beyond(material, 4)};
    struct {
      std::vector<std::int32_t> cells;
      std::vector<const Material*> material_at =
          std::vector<const Material*>(kElementPoints * kLanes);
    } waiting[2];  // elements within the body, and those whose corners all lie on its boundary
    const auto add_waiting = [&](bool spans) {
      auto& [cells, material_at] = waiting[spans];
      add_batch(material, number, points, cells, material_at);
      batches_.back().averaged = shares[spans];
      cells.clear();
    };
    for (Eigen::Index c = 0; c < mesh_.tets.rows(); ++c) {
      bool is_here = false, spans = true;
      for (int k = 0; k < 4; ++k) spans = spans && is_on_boundary[mesh_.tets(c, k)];
      auto& [cells, material_at] = waiting[spans];
      for (std::size_t q = 0; q < points.size(); ++q) {
        const Material* there = filling[points.size() * c + q];
        material_at[points.size() * cells.size() + q] = there;
        is_here |= there == &material;
      }
      if (is_here) cells.push_back(static_cast<std::int32_t>(c));
      if (cells.size() == kLanes) add_waiting(spans);
    }
    for (const bool spans : {false, true})
      if (!waiting[spans].cells.empty()) add_waiting(spans);
  }
}

void ElasticBody::add_batch(const Material& material, std::size_t number,
                            const std::vector<ElementPoint>& points,
                            const std::vector<std::int32_t>& cells,
                            const std::vector<const Material*>& material_at) {
  Batch batch;
  batch.law = material.law;
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
    for (int q = 0; q < kElementPoints; ++q) {
      for (int c = 0; c < constants; ++c)
        batch.constants.at(constants * q + c, lane) = material.constants[c];
      batch.weight.at(q, lane) = material_at[kElementPoints * lane + q] == &material;
    }
  }
  measure(points, batch);
  batches_.push_back(std::move(batch));
}

// Gradients of shape functions, weights where they are not 0, and the constant, without stress.
void ElasticBody::measure(const std::vector<ElementPoint>& points, Batch& batch) const {
  for (int lane = 0; lane < kLanes && batch.cell[lane] >= 0; ++lane) {
    Points nodes(kElementNodes, 3);
    for (int a = 0; a < kElementNodes; ++a) {
      const std::int32_t n = mesh_.tets(batch.cell[lane], a);
      nodes.row(a) = mesh_.nodes.row(n);
      if (strained_by_.rows() > 0) nodes.row(a) -= strained_by_.row(n);
    }
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(kElementPoints);
    for (int q = 0; q < kElementPoints; ++q) {
      const ElementPoint& point = points[q];
      Mat3 jacobian = Mat3::Zero();  // dX_i/dxi_j
      for (int a = 0; a < kElementNodes; ++a)
        jacobian += nodes.row(a).transpose() * point.by_xi.row(a);
      const double det = jacobian.determinant();
      const Eigen::MatrixXd gradient = point.by_xi * jacobian.inverse();
      for (int a = 0; a < kElementNodes; ++a)
        for (int j = 0; j < 3; ++j)
          batch.gradient.at(3 * (kElementNodes * q + a) + j, lane) = gradient(a, j);
      if (batch.weight.at(q, lane) == 0) continue;
      batch.weight.at(q, lane) = weight[q] = std::abs(det) * point.weight / 6;
    }
    const Eigen::VectorXd mode = unit_constant(weight);
    for (int q = 0; q < kElementPoints; ++q) batch.mode.at(q, lane) = mode[q];
  }
}

void ElasticBody::strain_by(Points u) {
  strained_by_ = std::move(u);
  const std::vector<ElementPoint> points = element_points();
  for (Batch& batch : batches_) measure(points, batch);
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

// Displacements as batches gather them; the last row is zero.
const double* ElasticBody::displacement_rows(const Points& u) const {
  double* rows = reinterpret_cast<double*>(displacement_rows_.data());
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    for (int i = 0; i < 3; ++i)
      rows[kPointStride * n + i] = strained_by_.rows() > 0 ? u(n, i) + strained_by_(n, i) : u(n, i);
  return rows;
}

double ElasticBody::integrate(Want want, const Points& u, double geometric_scale,
                              double max_pressure, Points* force, SymmetricBlockMatrix* K) const {
  double energy = 0;
  min_J_ = std::numeric_limits<double>::infinity();
  Pack displacement[3 * kElementNodes];
  CellResult result;
  const double* rows = displacement_rows(u);
  double* forces = reinterpret_cast<double*>(force_rows_.data());
  std::fill_n(forces, kPointStride * (u.rows() + 1), 0.0);
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const Batch& batch = batches_[b];
    batch.kernels.gather(rows, batch.points.data(), displacement);
    CellBatch cells{batch.gradient.data(),
                    batch.weight.data(),
                    batch.constants.data(),
                    batch.mode.data(),
                    batch.law->constants_used,
                    batch.averaged,
                    0,
                    geometric_scale};
    const CellKernels* kernels = &batch.kernels;
    if (step_) {
      kernels = &batch.kernels_in_step;
      cells.stiffening = step_->stiffening[b];
      cells.held = step_->held[b].data();
      cells.softening = softenings_[batch.material];
      cells.peak = step_->peak[b].data();
    }
    cells.max_pressure_Pa = max_pressure * cells.stiffening * batch.shear_modulus_Pa;
    kernels->integrate[static_cast<int>(want)](cells, batch.law->kernels->with(set_), displacement,
                                               result);
    for (int lane = 0; lane < kLanes; ++lane) {
      energy += result.energy[lane];
      min_J_ = std::min(min_J_, result.min_J[lane]);
    }
    if (force) kernels->scatter(result.force, batch.points.data(), forces);
    for (int lane = 0; K && lane < kLanes; ++lane) {
      if (batch.cell[lane] < 0) continue;
      const BlockPlace* place = places_.data() + kElementBlocks * batch.cell[lane];
      for (int block = 0; block < kElementBlocks; ++block)
        K->add(place[block], reinterpret_cast<const double*>(result.stiffness + 9 * block) + lane,
               kLanes);
    }
  }
  if (force)
    for (Eigen::Index n = 0; n < force->rows(); ++n)
      for (int i = 0; i < 3; ++i) (*force)(n, i) += forces[kPointStride * n + i];
  return energy;
}

double ElasticBody::energy(const Points& u) const {
  return integrate(Want::energy, u, 1, kUnbounded, nullptr, nullptr);
}

double ElasticBody::add_force(const Points& u, Points& force) const {
  return integrate(Want::force, u, 1, kUnbounded, &force, nullptr);
}

double ElasticBody::add_stiffness(const Points& u, double geometric_scale, Points& force,
                                  SymmetricBlockMatrix& K, double max_pressure) const {
  return integrate(Want::stiffness, u, geometric_scale, max_pressure, &force, &K);
}

}  // namespace palpate::fem
