#include <fmt/core.h>

#include <Eigen/LU>
#include <functional>

#include "libfem/elements/elastic_body.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "tools/bench/fem.hpp"

namespace palpate::fem::scalar {

// The integrals of a cell with one double at a time.
using Pack = double;
struct CellBatch {
  const double *gradient, *weight, *constants, *mode;
  int constant_count;
  double averaged, max_pressure_Pa;
};
struct CellResult {
  double energy, min_J, force[3 * kMaxNodes], stiffness[9 * blocks_of(kMaxNodes)];
};
struct LawKernels {
  void (*energy)(const double* constants, const double* H, double& J, double& W);
  void (*stress)(const double* constants, const double* H, double& J, double& W, double* P);
  void (*tangent)(const double* constants, const double* H, double geometric_scale, double& J,
                  double& W, double* P, double* A);
  void (*volumetric)(const double* constants, const double& dilation, double& U, double& U1,
                     double& U2);
  double min_dilation;
};

#include "libfem/elements/cell_integrals.inc"

}  // namespace palpate::fem::scalar

namespace palpate::tools {
namespace {

using namespace fem;

constexpr ElementShape kShape = shape_of(ElementKind::tet10_blend);

/// A body assembled cell by cell, as ElasticBody does it eight at a time; one material.
class ScalarBody {
 public:
  ScalarBody(const QuadraticMesh& mesh, const Material& material, const ElasticBody& like,
             const SymmetricBlockMatrix& K)
      : mesh_(mesh), free_(like.free_index()), material_(material) {
    const std::vector<CellPoint> points = cell_points(kShape);
    averaged_ = averaged_share(ElementKind::tet10_blend, material);
    for (int q = 0; q < kShape.points; ++q)
      for (int c = 0; c < material.law->constants_used; ++c)
        constants_.push_back(material.constants[static_cast<std::size_t>(c)]);
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
      Eigen::VectorXd weight(kShape.points);
      for (int q = 0; q < kShape.points; ++q) {
        const CellPoint& point = points[static_cast<std::size_t>(q)];
        Mat3 jacobian = Mat3::Zero();
        for (int a = 0; a < kShape.nodes; ++a)
          jacobian += mesh.nodes.row(mesh.tets(t, a)).transpose() * point.by_xi.row(a);
        const Eigen::MatrixXd gradient = point.by_xi * jacobian.inverse();
        for (int a = 0; a < kShape.nodes; ++a)
          for (int j = 0; j < 3; ++j) gradient_.push_back(gradient(a, j));
        weight[q] = jacobian.determinant() * point.weight / 6;
        weight_.push_back(weight[q]);
      }
      const Eigen::MatrixXd mode = orthonormal_modes(1, points, weight);
      mode_.insert(mode_.end(), mode.data(), mode.data() + mode.size());
      for (int a = 0; a < kShape.nodes; ++a)
        for (int b = 0; b <= a; ++b)
          places_.push_back(K.place(free_[mesh.tets(t, a)], free_[mesh.tets(t, b)]));
    }
  }

  template <scalar::Want kWant>
  void assemble(const Points& u, Points& force, SymmetricBlockMatrix& K) const {
    const scalar::LawKernels law{
        [](const double* c, const double* H, double& J, double& W) {
          NeoHookean::evaluate<double>(c, H, 1.0, J, W, nullptr, nullptr);
        },
        [](const double* c, const double* H, double& J, double& W, double* P) {
          NeoHookean::evaluate<double>(c, H, 1.0, J, W, P, nullptr);
        },
        [](const double* c, const double* H, double geometric_scale, double& J, double& W,
           double* P,
           double* A) { NeoHookean::evaluate<double>(c, H, geometric_scale, J, W, P, A); },
        [](const double* c, const double& dilation, double& U, double& U1, double& U2) {
          NeoHookean::volumetric<double>(c, dilation, U, U1, U2);
        },
        -1.0};
    constexpr int kBlocks = blocks_of(kShape.nodes);
    scalar::CellResult result;
    double displacement[3 * kMaxNodes];
    for (Eigen::Index t = 0; t < mesh_.tets.rows(); ++t) {
      for (int a = 0; a < kShape.nodes; ++a)
        for (int i = 0; i < 3; ++i) displacement[3 * a + i] = u(mesh_.tets(t, a), i);
      const scalar::CellBatch batch{gradient_.data() + t * 3 * kShape.nodes * kShape.points,
                                    weight_.data() + t * kShape.points,
                                    constants_.data(),
                                    mode_.data() + t * kShape.points,
                                    material_.law->constants_used,
                                    averaged_,
                                    1e300};
      scalar::run<kShape.nodes, kShape.points, 1, kWant>(batch, law, displacement, 1.0, result);
      for (int a = 0; a < kShape.nodes; ++a)
        for (int i = 0; i < 3; ++i) force(mesh_.tets(t, a), i) += result.force[3 * a + i];
      if constexpr (kWant == scalar::Want::stiffness)
        for (int block = 0; block < kBlocks; ++block)
          K.add(places_[static_cast<std::size_t>(kBlocks * t + block)],
                result.stiffness + 9 * block);
    }
  }

 private:
  const QuadraticMesh& mesh_;
  const std::vector<std::int32_t>& free_;
  Material material_;
  double averaged_ = 0;
  std::vector<double> gradient_, weight_, constants_, mode_;
  std::vector<BlockPlace> places_;
};

/// Kernels that are compared, and the least CPU time of a call over all rounds [s].
struct Timed {
  const char* name;
  std::function<void()> stiffness, residual;
  double stiffness_s = 1e300, residual_s = 1e300, difference = 0;
};

// Rounds go through all kernels in turn, so that what else the machine does slows them alike.
void time_in_turn(std::vector<Timed>& all) {
  constexpr int kRounds = 15, kCalls = 4;  // a residual takes a fifth of a stiffness
  const auto least = [](const std::function<void()>& work, double& best) {
    const double start = thread_cpu_s();
    work();
    best = std::min(best, thread_cpu_s() - start);
  };
  for (int round = 0; round < kRounds; ++round)
    for (Timed& one : all) {
      least(one.stiffness, one.stiffness_s);
      for (int call = 0; call < kCalls; ++call) least(one.residual, one.residual_s);
    }
}

}  // namespace

BenchTable fem_assembly(const BenchRequest& request) {
  const FemCase what = fem_block(0.45);
  GradeOptions grade;
  grade.growth = 0.6;
  grade.path = {{what.place, what.place, request.is_quick ? 4e-3 : 1.7e-3, 0}};
  const QuadraticMesh mesh =
      grade_mesh(what.setup.volume, what.setup.is_held, SmoothSurface(what.setup.surface), grade);
  const std::vector<Material> materials{make_material(what.setup.materials[0], "bench")};
  ElasticBody body(mesh, materials, {}, ElementKind::tet10_blend);
  SymmetricBlockMatrix K = body.pattern(), K_scalar = K;
  const ScalarBody one(mesh, materials[0], body, K_scalar);
  Points u(mesh.nodes.rows(), 3);  // a bend with strains up to a tenth
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    u.row(n) << 0, 0, 0.5 * mesh.nodes(n, 0) * mesh.nodes(n, 2);
  Points force = Points::Zero(u.rows(), 3), force_scalar = force;

  std::vector<Timed> all;
  all.push_back({"one double at a time",
                 [&] {
                   K_scalar.set_zero();
                   force_scalar.setZero();
                   one.assemble<scalar::Want::stiffness>(u, force_scalar, K_scalar);
                 },
                 [&] {
                   force_scalar.setZero();
                   one.assemble<scalar::Want::force>(u, force_scalar, K_scalar);
                 }});
  const auto use = [&](InstructionSet set) {
    body.use(set);
    K.set_zero();
    force.setZero();
  };
  constexpr std::pair<InstructionSet, const char*> kSets[] = {
      {InstructionSet::portable, "eight, portable"},
      {InstructionSet::avx2, "eight, AVX2"},
      {InstructionSet::avx512, "eight, AVX-512"}};
  for (const auto& [set, name] : kSets)
    if (has_instruction_set(set))
      all.push_back({name,
                     [&, set = set] {
                       use(set);
                       body.add_stiffness(u, 1.0, force, K);
                     },
                     [&, set = set] {
                       body.use(set);
                       force.setZero();
                       body.add_force(u, force);
                     }});
  time_in_turn(all);

  const Eigen::VectorXd ones = Eigen::VectorXd::LinSpaced(K.size(), 0, 1);
  Eigen::VectorXd y, y_scalar;
  all[0].stiffness();
  K_scalar.multiply(ones, y_scalar);
  for (std::size_t k = 1; k < all.size(); ++k) {
    all[k].stiffness();
    K.multiply(ones, y);
    all[k].difference =
        std::max((force - force_scalar).norm() / force.norm(), (y - y_scalar).norm() / y.norm());
  }
  BenchTable table{{"kernels", "cells", "stiffness_ns_per_cell", "residual_ns_per_cell",
                    "scalar/this_stiffness", "scalar/this_residual", "largest_difference"},
                   {}};
  const double per_cell = 1e9 / static_cast<double>(mesh.tets.rows());
  for (const Timed& of : all)
    table.rows.push_back({of.name, fmt::format("{}", mesh.tets.rows()),
                          fmt::format("{:.0f}", per_cell * of.stiffness_s),
                          fmt::format("{:.0f}", per_cell * of.residual_s),
                          fmt::format("{:.2f}", all[0].stiffness_s / of.stiffness_s),
                          fmt::format("{:.2f}", all[0].residual_s / of.residual_s),
                          fmt::format("{:.1e}", of.difference)});
  return table;
}

}  // namespace palpate::tools
