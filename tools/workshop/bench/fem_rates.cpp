#include <fmt/core.h>

#include <numeric>

#include "libfem/elements/elastic_body.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/factor/schur_factor.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/fem.hpp"

extern "C" {
void sgemm_(const char*, const char*, const int*, const int*, const int*, const float*,
            const float*, const int*, const float*, const int*, const float*, float*, const int*);
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*,
            const double*, const int*, const double*, const int*, const double*, double*,
            const int*);
}

namespace palpate::tools {
namespace {

using namespace fem;

template <class Work>
double min_s(int rounds, const Work& work) {
  double best = 1e300;
  for (int round = 0; round < rounds; ++round) {
    const double start = thread_cpu_s();
    work();
    best = std::min(best, thread_cpu_s() - start);
  }
  return best;
}

template <class Real, class Gemm>
double gemm_GF_s(const Gemm& gemm) {
  const int n = 1500;
  const std::vector<Real> a(std::size_t(n) * n, Real(1.5)), b(std::size_t(n) * n, Real(0.5));
  std::vector<Real> c(std::size_t(n) * n, Real(0));
  const Real one = 1, zero = 0;
  const double s = min_s(5, [&] {
    gemm("N", "N", &n, &n, &n, &one, a.data(), &n, b.data(), &n, &zero, c.data(), &n);
  });
  return 2e-9 * n * n * n / s;
}

volatile float kept;  // so that no read is optimized away

// Bytes a second that one thread reads in order from an array of this size.
double streaming_read_GB_s(std::size_t bytes) {
  const Eigen::VectorXf block =
      Eigen::VectorXf::Ones(static_cast<Eigen::Index>(bytes / sizeof(float)));
  return 1e-9 * static_cast<double>(bytes) / min_s(7, [&] { kept = block.sum(); });
}

}  // namespace

BenchTable fem_rates(const BenchRequest& request) {
  const FemCase what = fem_block(0.45);
  const SmoothSurface surface(what.setup.surface);
  const std::vector<Material> materials{make_material(what.setup.materials[0], "bench")};
  BenchTable table{
      {"nodes", "factor_GF", "factor_MB", "mesh_s", "analysis_s", "factor_s", "solve_ms",
       "stiffness_ms", "factor_GF_s", "sgemm_GF_s", "dgemm_GF_s", "factor/dgemm_percent",
       "solve_GB_s", "read_GB_s", "solve/read_percent", "double_factor_s"},
      {}};
  struct MeshSize {
    double h_m, growth;
  };
  // The largest takes 40 GF and more.
  const std::vector<MeshSize> sizes =
      request.is_quick ? std::vector<MeshSize>{{6e-3, 0.6}}
                       : std::vector<MeshSize>{
                             {2e-3, 0.6}, {1.5e-3, 0.45}, {1e-3, 0.4}, {1e-3, 0.33}, {0.8e-3, 0.2}};
  for (const MeshSize& size : sizes) {
    GradeOptions grade;
    grade.growth = size.growth;
    grade.path = {{what.place, what.place, size.h_m, 0}};
    double start = thread_cpu_s();
    const QuadraticMesh mesh = grade_mesh(what.setup.volume, what.setup.is_held, surface, grade);
    const double mesh_s = thread_cpu_s() - start;
    const ElasticBody body(mesh, materials, {});
    SymmetricBlockMatrix K = body.pattern();
    Points force = Points::Zero(mesh.nodes.rows(), 3);
    const Points u = force;
    const double stiffness_s = min_s(3, [&] {
      K.set_zero();
      body.add_stiffness(u, 1.0, force, K);
    });
    Elimination plan;
    const double analysis_s = min_s(1, [&] { plan = analyse_elimination(K, dissect(K), {}); });
    SchurFactor factor;
    factor.factor(K, {});
    // The first factorization opens its memory; later ones of a press find it open.
    const double factor_s = min_s(2, [&] { factor.factor(K, {}); });
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(K.size(), -1, 1);
    Eigen::VectorXd x;
    const double solve_s = min_s(7, [&] { factor.solve(b, x); });
    double flops = 0, entries = 0;
    for (int s = 0; s < plan.supernodes(); ++s)
      for (double rows = 3 * plan.height(s), c = 0; c < 3 * plan.columns(s); ++c, --rows) {
        flops += rows * rows;
        entries += rows;
      }
    const double bytes = 4.0 * entries;
    FrontalFactor exact;
    EliminationRoom<double> room;
    eliminate(plan, K, room, exact);
    const double double_s = min_s(1, [&] { eliminate(plan, K, room, exact); });
    const double dgemm = gemm_GF_s<double>(dgemm_), sgemm = gemm_GF_s<float>(sgemm_);
    const double read = streaming_read_GB_s(
        std::max<std::size_t>(static_cast<std::size_t>(bytes), std::size_t{1} << 20));
    const double factor_rate = 1e-9 * flops / factor_s;
    const double solve_rate = 2e-9 * bytes / solve_s;
    table.rows.push_back(
        {fmt::format("{}", mesh.nodes.rows()), fmt::format("{:.2f}", 1e-9 * flops),
         fmt::format("{:.0f}", 1e-6 * bytes), fmt::format("{:.3f}", mesh_s),
         fmt::format("{:.3f}", analysis_s), fmt::format("{:.3f}", factor_s),
         fmt::format("{:.2f}", 1e3 * solve_s), fmt::format("{:.2f}", 1e3 * stiffness_s),
         fmt::format("{:.1f}", factor_rate), fmt::format("{:.1f}", sgemm),
         fmt::format("{:.1f}", dgemm), fmt::format("{:.0f}", 100 * factor_rate / dgemm),
         fmt::format("{:.1f}", solve_rate), fmt::format("{:.1f}", read),
         fmt::format("{:.0f}", 100 * solve_rate / read), fmt::format("{:.3f}", double_s)});
  }
  return table;
}

}  // namespace palpate::tools
