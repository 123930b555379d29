#include "libfem/calibrate/homogeneous_tests.hpp"

#include <Eigen/LU>
#include <cmath>

namespace palpate::fem {
namespace {

/// Minimises the energy over the free sides (M45), from those of F. False where that fails.
bool relax_free_sides(const Material& material, std::string_view sides, double modulus_Pa,
                      Mat3& F) {
  std::vector<int> free, entries;  // of the diagonal, and their places among the entries of F
  for (int i = 0; i < 3; ++i)
    if (sides[i] == 'f') {
      free.push_back(i);
      entries.push_back(4 * i);
    }
  if (free.empty()) return true;
  LawPoint now = material.law->evaluate(material.constants, F);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Eigen::VectorXd g = now.P.diagonal()(free);
    if (!g.allFinite()) return false;
    // A free side may keep this share of the stress that is measured.
    if (g.lpNorm<Eigen::Infinity>() <= 1e-7 * (now.P.norm() + modulus_Pa)) return true;
    const Eigen::MatrixXd K = now.A(entries, entries);
    const Eigen::VectorXd step = -K.fullPivLu().solve(g);
    double share = 1;
    for (;; share /= 2) {  // the residual counts where the energy has no digits left
      if (share < 1e-6) return false;
      Mat3 next = F;
      next.diagonal()(free) += share * step;
      if (!(next.diagonal().array() > 0.2 * F.diagonal().array()).all()) continue;
      const LawPoint tried = material.law->evaluate(material.constants, next);
      if (tried.P.diagonal()(free).norm() < g.norm() || tried.W < now.W) {
        F = next;
        now = tried;
        break;
      }
    }
  }
  return false;
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
      F(k, k) = sides[k] == 'l' ? l : sides[k] == 'f' ? std::pow(l, -set / free) : 1;
    }
    if (test.row->is_shear) F(0, 1) = l;
    if (!relax_free_sides(material, sides, modulus_Pa, F)) return {};
    const auto [W, P, A] = material.law->evaluate(material.constants, F);
    if (!std::isfinite(W)) return {};
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
