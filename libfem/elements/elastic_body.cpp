#include "libfem/elements/elastic_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

template <class Cells>
void divide_in_eight(const QuadraticMesh& mesh, Cells& cells) {
  cells.resize(8 * mesh.tets.rows(), 4);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    Eigen::Matrix<double, 10, 3> nodes;
    for (int a = 0; a < 10; ++a) nodes.row(a) = mesh.nodes.row(mesh.tets(t, a));
    const auto pieces = eight_tets(nodes);
    for (int piece = 0; piece < 8; ++piece)
      for (int a = 0; a < 4; ++a) cells(8 * t + piece, a) = mesh.tets(t, pieces[piece][a]);
  }
}

}  // namespace

ElasticBody::ElasticBody(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at, ElementKind element)
    : mesh_(mesh),
      displacement_rows_(mesh.nodes.rows() / 2 + 1),
      force_rows_(mesh.nodes.rows() / 2 + 1) {
  for (const char is_held : mesh.is_held) free_index_.push_back(is_held ? -1 : free_nodes_++);
  if (element == ElementKind::tet4)
    divide_in_eight(mesh, cells_);
  else
    cells_ = mesh.tets;

  for (const Material& material : materials) {
    const ElementKind kind = element_for(element, material);
    const std::vector<CellPoint> points = cell_points(shape_of(kind));
    std::vector<const Material*> material_at(points.size() * kLanes);
    std::vector<std::int32_t> cells;
    for (Eigen::Index c = 0; c < cells_.rows(); ++c) {
      bool is_here = false;
      for (std::size_t q = 0; q < points.size(); ++q) {
        Vec3 place = Vec3::Zero();
        for (Eigen::Index a = 0; a < cells_.cols(); ++a)
          place += points[q].shape[a] * mesh.nodes.row(cells_(c, a)).transpose();
        const Material* there =
            &materials.at(region_at ? static_cast<std::size_t>(region_at(place)) : 0);
        material_at[points.size() * cells.size() + q] = there;
        is_here |= there == &material;
      }
      if (is_here) cells.push_back(static_cast<std::int32_t>(c));
      if (cells.size() == kLanes)
        add_batch(material, kind, points, cells, material_at), cells.clear();
    }
    if (!cells.empty()) add_batch(material, kind, points, cells, material_at);
  }
}

void ElasticBody::add_batch(const Material& material, ElementKind element,
                            const std::vector<CellPoint>& points,
                            const std::vector<std::int32_t>& cells,
                            const std::vector<const Material*>& material_at) {
  Batch batch;
  batch.law = material.law;
  batch.element = element;
  batch.averaged = averaged_share(element, material);
  batch.shear_modulus_Pa = material.law->small_strain(material.constants).mu_Pa;
  batch.kernels = cell_kernels(element, set_);
  batch.points.assign(cells_.cols() * kLanes, static_cast<std::int32_t>(mesh_.nodes.rows()));
  const ElementShape shape = shape_of(element);
  const int constants = material.law->constants_used;
  batch.gradient = PackArray(shape.points * shape.nodes * 3);
  batch.weight = PackArray(shape.points);
  batch.constants = PackArray(shape.points * constants);
  batch.mode = PackArray(shape.modes * shape.points);
  for (int lane = 0; lane < kLanes; ++lane) {
    batch.cell[lane] = lane < static_cast<int>(cells.size()) ? cells[lane] : -1;
    if (batch.cell[lane] < 0) continue;
    for (Eigen::Index a = 0; a < cells_.cols(); ++a)
      batch.points[kLanes * a + lane] = cells_(cells[lane], a);
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(shape.points);
    for (int q = 0; q < shape.points; ++q) {
      const CellPoint& point = points[q];
      Mat3 jacobian = Mat3::Zero();  // dX_i/dxi_j
      for (int a = 0; a < shape.nodes; ++a)
        jacobian += mesh_.nodes.row(cells_(cells[lane], a)).transpose() * point.by_xi.row(a);
      const double det = jacobian.determinant();
      const Eigen::MatrixXd gradient = point.by_xi * jacobian.inverse();
      for (int a = 0; a < shape.nodes; ++a)
        for (int j = 0; j < 3; ++j)
          batch.gradient.at(3 * (shape.nodes * q + a) + j, lane) = gradient(a, j);
      for (int c = 0; c < constants; ++c)
        batch.constants.at(constants * q + c, lane) = material.constants[c];
      if (material_at[shape.points * lane + q] != &material) continue;  // weight stays 0
      weight[q] = std::abs(det) * point.weight / 6;
      batch.weight.at(q, lane) = weight[q];
      rest_volume_m3_ += det * point.weight / 6;
    }
    const Eigen::MatrixXd mode = orthonormal_modes(shape.modes, points, weight);
    for (int m = 0; m < shape.modes; ++m)
      for (int q = 0; q < shape.points; ++q) batch.mode.at(shape.points * m + q, lane) = mode(m, q);
  }
  batches_.push_back(std::move(batch));
}

void ElasticBody::use(InstructionSet set) {
  set_ = set;
  for (Batch& batch : batches_) batch.kernels = cell_kernels(batch.element, set);
}

SymmetricBlockMatrix ElasticBody::pattern() const {
  std::vector<std::vector<std::int32_t>> neighbours(free_nodes_);
  for (Eigen::Index c = 0; c < cells_.rows(); ++c)
    for (Eigen::Index a = 0; a < cells_.cols(); ++a)
      for (Eigen::Index b = 0; b < cells_.cols(); ++b) {
        const std::int32_t i = free_index_[cells_(c, a)], j = free_index_[cells_(c, b)];
        if (i > j && j >= 0) neighbours[j].push_back(i);
      }
  // Contact couples the six nodes of a face, linear pieces do not.
  for (Eigen::Index f = 0; cells_.cols() < 10 && f < mesh_.faces.rows(); ++f)
    for (const std::int32_t a : mesh_.faces.row(f))
      for (const std::int32_t b : mesh_.faces.row(f))
        if (free_index_[a] > free_index_[b] && free_index_[b] >= 0)
          neighbours[free_index_[b]].push_back(free_index_[a]);
  SymmetricBlockMatrix K(neighbours);
  places_.clear();
  for (Eigen::Index c = 0; c < cells_.rows(); ++c)
    for (Eigen::Index a = 0; a < cells_.cols(); ++a)
      for (Eigen::Index b = 0; b <= a; ++b)
        places_.push_back(K.place(free_index_[cells_(c, a)], free_index_[cells_(c, b)]));
  return K;
}

// Adds what batches have left in force_rows_.
void ElasticBody::add_force_rows(Points& force) const {
  const double* row = reinterpret_cast<const double*>(force_rows_.data());
  for (Eigen::Index n = 0; n < force.rows(); ++n, row += kPointStride)
    for (int i = 0; i < 3; ++i) force(n, i) += row[i];
}

template <class Visit>
double ElasticBody::visit_batches(const Points& u, const Visit& visit) const {
  double energy = 0;
  min_J_ = std::numeric_limits<double>::infinity();
  Pack displacement[3 * kMaxNodes];
  CellResult result;
  double* rows = reinterpret_cast<double*>(displacement_rows_.data());
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    for (int i = 0; i < 3; ++i) rows[kPointStride * n + i] = u(n, i);
  std::fill_n(reinterpret_cast<double*>(force_rows_.data()), kPointStride * (u.rows() + 1), 0.0);
  for (const Batch& batch : batches_) {
    batch.kernels.gather(rows, batch.points.data(), displacement);
    visit(batch,
          CellBatch{batch.gradient.data(), batch.weight.data(), batch.constants.data(),
                    batch.mode.data(), batch.law->constants_used, batch.averaged,
                    std::numeric_limits<double>::infinity()},
          batch.law->kernels->with(set_), displacement, result);
    for (int lane = 0; lane < kLanes; ++lane) {
      energy += result.energy[lane];
      min_J_ = std::min(min_J_, result.min_J[lane]);
    }
  }
  return energy;
}

double ElasticBody::energy(const Points& u) const {
  return visit_batches(u, [](const Batch& batch, const CellBatch& cells, const LawKernels& law,
                             const Pack* displacement, CellResult& result) {
    batch.kernels.energy(cells, law, displacement, result);
  });
}

double ElasticBody::add_force(const Points& u, Points& force) const {
  double* rows = reinterpret_cast<double*>(force_rows_.data());
  const double energy =
      visit_batches(u, [&](const Batch& batch, const CellBatch& cells, const LawKernels& law,
                           const Pack* displacement, CellResult& result) {
        batch.kernels.force(cells, law, displacement, result);
        batch.kernels.scatter(result.force, batch.points.data(), rows);
      });
  add_force_rows(force);
  return energy;
}

double ElasticBody::add_stiffness(const Points& u, double geometric_scale, Points& force,
                                  SymmetricBlockMatrix& K, double max_pressure) const {
  const int blocks = blocks_of(static_cast<int>(cells_.cols()));
  double* rows = reinterpret_cast<double*>(force_rows_.data());
  const double energy =
      visit_batches(u, [&](const Batch& batch, CellBatch cells, const LawKernels& law,
                           const Pack* displacement, CellResult& result) {
        cells.max_pressure_Pa = max_pressure * batch.shear_modulus_Pa;
        batch.kernels.stiffness(cells, law, displacement, geometric_scale, result);
        batch.kernels.scatter(result.force, batch.points.data(), rows);
        for (int lane = 0; lane < kLanes; ++lane) {
          if (batch.cell[lane] < 0) continue;
          const BlockPlace* place = places_.data() + blocks * batch.cell[lane];
          for (int block = 0; block < blocks; ++block)
            K.add(place[block],
                  reinterpret_cast<const double*>(result.stiffness + 9 * block) + lane, kLanes);
        }
      });
  add_force_rows(force);
  return energy;
}

}  // namespace palpate::fem
