#include "libfem/solve/experiments/simulate.hpp"

#include <cmath>
#include <vector>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {

double force_at_first(const Simulator& simulator, const TestPoints& points,
                      const Experiments& experiments, const Progress& progress) {
  std::vector<double> ratios;
  for (Eigen::Index p = 0; p < points.position.rows() && !progress.stopped(); ++p) {
    const Vec3 position = points.position.row(p), normal = points.normal.row(p);
    const PointRows slow = simulator.press_quickly(position, normal, experiments, progress);
    const PointRows first = simulator.press_at_once(position, normal, experiments, progress);
    for (Eigen::Index i = 0; i < slow.rows() && i < first.rows(); ++i)
      if (slow.status[i] == RowStatus::good && first.status[i] == RowStatus::good &&
          slow.force.row(i).dot(normal) > 0)
        ratios.push_back(first.force.row(i).dot(normal) / slow.force.row(i).dot(normal));
  }
  return ratios.empty() ? 0 : median(ratios);
}

// With shear modulus s (1 in slow motion) and bulk modulus K + k s, the plane modulus of a
// half-space is 4 s (3K + (3k + 1) s) / (3K + (3k + 4) s) = 4 [ (p/q) s + c - m c / (m + q s) ]
// with m = 3K, p = 3k + 1, q = 3k + 4, c = 3m/q^2. The first term relaxes as the shear does. Of the
// last, m + q s(P) = b - q sum g_k / (1 + P tau_k) is inverted by Woodbury's identity and the modes
// of diag(tau) and the matrix of rank one that is left.
Relaxation relaxation_of_contact(const Material& material, double at_first) {
  const Relaxation& shear = material.relaxation;
  if (shear.branches() == 0) return {};
  double U, U1, U2;
  material.law->volumetric(material.constants, 0, U, U1, U2);
  const SmallStrain moduli = material.law->small_strain(material.constants);
  const double m = 3 * U2 / moduli.mu_Pa, k = (moduli.bulk_Pa() - U2) / moduli.mu_Pa;
  const double p = 3 * k + 1, q = 3 * k + 4, c = 3 * m / (q * q);
  const double slow = p / q + c - m * c / (m + q), b = m + q * instantaneous_stiffness(shear);

  const Eigen::VectorXd root = (q * shear.share).cwiseSqrt();
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(root.size(), root.size()) - root * root.transpose() / b;
  const Eigen::MatrixXd times = shear.time_s.asDiagonal();
  const SymmetricEigen modes = symmetric_eigen(left, times);
  Relaxation out = shear;
  for (Eigen::Index branch = 0; branch < shear.branches(); ++branch) {
    const Eigen::Index mode = shear.branches() - 1 - branch;  // rates rise, times fall
    const double rate = modes.values[mode];
    const double direct = p / q * shear.share[branch] / slow;
    const double volume =
        m * c / (b * b) / rate / slow * std::pow(root.dot(modes.vectors.col(mode)), 2);
    out.share[branch] = direct + volume;
    out.time_s[branch] =
        (direct * shear.time_s[branch] + volume / rate) / out.share[branch];  // same area
  }
  if (at_first > 0) out.share *= (at_first - 1) / out.share.sum();
  return out;
}

}  // namespace palpate::fem
