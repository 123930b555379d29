#include "libfem/solve/elastic_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

using TetGradient = Eigen::Matrix<double, kTetNodes, 3, Eigen::RowMajor>;

constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

// Four points, exact to degree 2 (Keast 1986, doi:10.1016/0045-7825(86)90059-9), weights 1/24.
constexpr double kNear = 0.585410196624968454, kFar = 0.138196601125010515;

/// Shape functions and their derivatives by the barycentric coordinates 1 to 3 at point q.
void shape_at(int q, Eigen::Matrix<double, kTetNodes, 1>& shape, TetGradient& by_xi) {
  std::array<double, 4> L;
  L.fill(kFar);
  L[q] = kNear;
  // Rows: dL_c/dxi_j.
  constexpr double dL[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int c = 0; c < 4; ++c) {
    shape[c] = L[c] * (2 * L[c] - 1);
    for (int j = 0; j < 3; ++j) by_xi(c, j) = (4 * L[c] - 1) * dL[c][j];
  }
  for (int e = 0; e < 6; ++e) {
    const int a = kTetEdges[e][0], b = kTetEdges[e][1];
    shape[4 + e] = 4 * L[a] * L[b];
    for (int j = 0; j < 3; ++j) by_xi(4 + e, j) = 4 * (L[a] * dL[b][j] + L[b] * dL[a][j]);
  }
}

}  // namespace

ElasticBody::ElasticBody(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at)
    : mesh_(mesh) {
  for (const char is_held : mesh.is_held) free_index_.push_back(is_held ? -1 : free_nodes_++);

  // Material of every quadrature point; elements are grouped by law.
  std::vector<std::vector<const Material*>> material(mesh.tets.rows());
  std::vector<const LawRow*> laws;
  Eigen::Matrix<double, kTetNodes, 1> shape;
  TetGradient by_xi;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    for (int q = 0; q < kTetPoints; ++q) {
      shape_at(q, shape, by_xi);
      Vec3 place = Vec3::Zero();
      for (int a = 0; a < kTetNodes; ++a) place += shape[a] * mesh.nodes.row(mesh.tets(t, a)).transpose();
      const int region = region_at ? region_at(place) : 0;
      material[t].push_back(&materials.at(static_cast<std::size_t>(region)));
      if (std::find(laws.begin(), laws.end(), material[t].back()->law) == laws.end())
        laws.push_back(material[t].back()->law);
    }
  }
  for (const LawRow* law : laws) {
    std::vector<std::int32_t> elements;
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
      const bool is_of_law = std::any_of(material[t].begin(), material[t].end(),
                                         [law](const Material* m) { return m->law == law; });
      if (is_of_law) elements.push_back(static_cast<std::int32_t>(t));
      if (elements.size() == kLanes) add_batch(law, elements, material), elements.clear();
    }
    if (!elements.empty()) add_batch(law, elements, material);
  }
}

void ElasticBody::add_batch(const LawRow* law, const std::vector<std::int32_t>& elements,
                            const std::vector<std::vector<const Material*>>& material) {
  Batch batch;
  batch.law = law;
  const int constants = law->constants_used;
  batch.gradient = PackArray(kTetPoints * kTetNodes * 3);
  batch.weight = PackArray(kTetPoints);
  batch.constants = PackArray(kTetPoints * constants);
  Eigen::Matrix<double, kTetNodes, 1> shape;
  TetGradient by_xi;
  for (int lane = 0; lane < kLanes; ++lane) {
    batch.element[lane] = lane < static_cast<int>(elements.size()) ? elements[lane] : -1;
    if (batch.element[lane] < 0) continue;
    const std::int32_t t = elements[lane];
    double sum = 0, least = std::numeric_limits<double>::infinity();
    for (int q = 0; q < kTetPoints; ++q) {
      shape_at(q, shape, by_xi);
      Mat3 jacobian = Mat3::Zero();  // dX_i/dxi_j
      for (int a = 0; a < kTetNodes; ++a)
        jacobian += mesh_.nodes.row(mesh_.tets(t, a)).transpose() * by_xi.row(a);
      const double det = jacobian.determinant();
      sum += det, least = std::min(least, det);
      const TetGradient gradient = by_xi * jacobian.inverse();
      for (int a = 0; a < kTetNodes; ++a)
        for (int j = 0; j < 3; ++j)
          batch.gradient.at(3 * (kTetNodes * q + a) + j, lane) = gradient(a, j);
      const Material& here = *material[t][q];
      if (here.law != law) continue;  // weight stays 0
      batch.weight.at(q, lane) = std::abs(det) / 24;
      rest_volume_m3_ += det / 24;
      for (int c = 0; c < constants; ++c) 
        batch.constants.at(constants * q + c, lane) = here.constants[c];
    }
    least_rest_jacobian_ = std::min(least_rest_jacobian_, kTetPoints * least / std::abs(sum));
  }
  batches_.push_back(std::move(batch));
}

SymmetricBlockMatrix ElasticBody::pattern() const {
  std::vector<std::vector<std::int32_t>> neighbours(free_nodes_);
  for (Eigen::Index t = 0; t < mesh_.tets.rows(); ++t)
    for (int a = 0; a < kTetNodes; ++a)
      for (int b = 0; b < kTetNodes; ++b) {
        const std::int32_t i = free_index_[mesh_.tets(t, a)], j = free_index_[mesh_.tets(t, b)];
        if (i > j && j >= 0) neighbours[j].push_back(i);
      }
  SymmetricBlockMatrix K(neighbours);
  places_.clear();
  for (Eigen::Index t = 0; t < mesh_.tets.rows(); ++t)
    for (int a = 0; a < kTetNodes; ++a)
      for (int b = 0; b <= a; ++b)
        places_.push_back(K.place(free_index_[mesh_.tets(t, a)], free_index_[mesh_.tets(t, b)]));
  return K;
}

void ElasticBody::gather(const Batch& batch, const Points& u, Pack* displacement) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int32_t t = batch.element[lane];
    for (int a = 0; a < kTetNodes; ++a)
      for (int i = 0; i < 3; ++i)
        displacement[3 * a + i][lane] = t < 0 ? 0.0 : u(mesh_.tets(t, a), i);
  }
}

void ElasticBody::scatter_force(const Batch& batch, const ElementResult& result,
                                Points& force) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int32_t t = batch.element[lane];
    if (t < 0) continue;
    for (int a = 0; a < kTetNodes; ++a)
      for (int i = 0; i < 3; ++i) force(mesh_.tets(t, a), i) += result.force[3 * a + i][lane];
  }
}

template <class Visit>
double ElasticBody::visit_batches(const Points& u, const Visit& visit) const {
  double energy = 0;
  least_J_ = std::numeric_limits<double>::infinity();
  Pack displacement[3 * kTetNodes];
  ElementResult result;
  for (const Batch& batch : batches_) {
    gather(batch, u, displacement);
    visit(batch, ElementBatch{batch.gradient.data(), batch.weight.data(), batch.constants.data()},
          displacement, result);
    for (int lane = 0; lane < kLanes; ++lane) {
      energy += result.energy[lane];
      least_J_ = std::min(least_J_, result.least_J[lane]);
    }
  }
  return energy;
}

double ElasticBody::energy(const Points& u) const {
  return visit_batches(u, [](const Batch& batch, const ElementBatch& elements,
                             const Pack* displacement, ElementResult& result) {
    batch.law->kernels->energy(elements, displacement, result);
  });
}

double ElasticBody::add_force(const Points& u, Points& force) const {
  return visit_batches(u, [&](const Batch& batch, const ElementBatch& elements,
                              const Pack* displacement, ElementResult& result) {
    batch.law->kernels->force(elements, displacement, result);
    scatter_force(batch, result, force);
  });
}

double ElasticBody::add_stiffness(const Points& u, double bend, Points& force,
                                  SymmetricBlockMatrix& K) const {
  return visit_batches(u, [&](const Batch& batch, const ElementBatch& elements,
                              const Pack* displacement, ElementResult& result) {
    batch.law->kernels->stiffness(elements, displacement, bend, result);
    scatter_force(batch, result, force);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (batch.element[lane] < 0) continue;
      const BlockPlace* place = places_.data() + kTetBlocks * batch.element[lane];
      for (int block = 0; block < kTetBlocks; ++block)
        K.add(place[block],
              reinterpret_cast<const double*>(result.stiffness + 9 * block) + lane, kLanes);
    }
  });
}

}  // namespace palpate::fem
