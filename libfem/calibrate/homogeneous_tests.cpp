#include "libfem/calibrate/homogeneous_tests.hpp"

#include <Eigen/LU>
#include <cmath>

namespace palpate::fem {
namespace {

constexpr int kMaxIterations = 60;
constexpr double kFreeStress = 1e-7;  // left on a free side, over the stress that is measured

/// Minimises the energy over the free sides (M45), from those of F. False where that fails.
bool relax_free_sides(const Material& material, std::string_view sides, double modulus_Pa,
                      Mat3& F) {
  std::vector<int> free;
  for (int i = 0; i < 3; ++i)
    if (sides[static_cast<std::size_t>(i)] == 'f') free.push_back(i);
  const auto n = static_cast<Eigen::Index>(free.size());
  for (int iteration = 0; iteration < kMaxIterations && n > 0; ++iteration) {
    const Mat3 P = material.law->stress(material.constants, F);
    Eigen::VectorXd g(n);
    for (Eigen::Index i = 0; i < n; ++i) g[i] = P(free[i], free[i]);
    if (!g.allFinite()) return false;
    if (g.lpNorm<Eigen::Infinity>() <= kFreeStress * (P.norm() + modulus_Pa)) return true;
    const Mat9 A = material.law->tangent(material.constants, F);
    Eigen::MatrixXd K(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) K(i, j) = A(4 * free[i], 4 * free[j]);
    const Eigen::VectorXd step = -K.fullPivLu().solve(g);
    const double energy = material.law->energy(material.constants, F);
    double share = 1;
    for (;; share /= 2) {  // the residual counts where the energy has no digits left
      Mat3 next = F;
      bool is_inside = true;
      for (Eigen::Index i = 0; i < n; ++i) {
        next(free[i], free[i]) += share * step[i];
        is_inside = is_inside && next(free[i], free[i]) > 0.2 * F(free[i], free[i]);
      }
      if (is_inside) {
        const Mat3 stress = material.law->stress(material.constants, next);
        Eigen::VectorXd left(n);
        for (Eigen::Index i = 0; i < n; ++i) left[i] = stress(free[i], free[i]);
        if (left.norm() < g.norm() || material.law->energy(material.constants, next) < energy) {
          F = next;
          break;
        }
      }
      if (share < 1e-6) return false;
    }
  }
  return n == 0;
}

}  // namespace

Eigen::VectorXd stresses(const Material& material, const HomogeneousTest& test) {
  Eigen::VectorXd out(test.stretch.size());
  const std::string_view sides = test.row->sides;
  const auto free = static_cast<double>(std::count(sides.begin(), sides.end(), 'f'));
  const auto set = static_cast<double>(std::count(sides.begin(), sides.end(), 'l'));
  const double modulus_Pa = material.law->small_strain(material.constants).mu_Pa;
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const double l = test.stretch[i];
    Mat3 F = Mat3::Identity();
    for (int k = 0; k < 3; ++k) {
      const char side = sides[static_cast<std::size_t>(k)];
      F(k, k) = side == 'l' ? l : side == 'f' ? std::pow(l, -set / free) : 1;
    }
    if (test.row->is_shear) F(0, 1) = l;
    if (!relax_free_sides(material, sides, modulus_Pa, F)) return {};
    if (!std::isfinite(material.law->energy(material.constants, F))) return {};
    const Mat3 P = material.law->stress(material.constants, F);
    const Mat3 stress = test.is_true ? Mat3(P * F.transpose() / F.determinant()) : P;
    out[i] = test.row->is_shear ? stress(0, 1) : stress(0, 0);
  }
  return out.allFinite() ? out : Eigen::VectorXd();
}

Eigen::VectorXd stresses(const MaterialParameters& parameters,
                         const std::vector<HomogeneousTest>& tests) {
  const Material material = make_material(parameters, "[material]");
  Eigen::VectorXd out(0);
  for (const HomogeneousTest& test : tests) {
    const Eigen::VectorXd part = stresses(material, test);
    if (part.size() != test.stretch.size()) return {};
    out.conservativeResize(out.size() + part.size());
    out.tail(part.size()) = part;
  }
  return out;
}

HomogeneousTest thinned(const HomogeneousTest& test, Eigen::Index rows) {
  const Eigen::Index n = test.stretch.size();
  if (n <= rows) return test;
  HomogeneousTest out = test;
  out.stretch.resize(rows), out.stress.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    out.stretch[i] = test.stretch[i * (n - 1) / (rows - 1)];
    out.stress[i] = test.stress[i * (n - 1) / (rows - 1)];
  }
  return out;
}

}  // namespace palpate::fem
