#include "libfit/fit/contact_effects.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/runtime/asset/view.hpp"

namespace palpate {
namespace {

constexpr int kUnknowns = 2 * runtime::kCouplingScales;
// Limit of compliances, over what the softest place allows a probe: beyond it all contacts have
// their bound (coupling_share), but those of balls that are narrower.
constexpr double kLimit = 3;

using Unknowns = Eigen::Vector<double, kUnknowns>;

runtime::CouplingView coupling_of(double length_m, const Unknowns& of) {
  runtime::CouplingView out;
  out.length_m = length_m;
  for (int k = 0; k < runtime::kCouplingScales; ++k) {
    out.isotropic_m_N[k] = of[k];
    out.tangential_m_N[k] = of[runtime::kCouplingScales + k];
  }
  return out;
}

using Gram = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// argmin x'Gx/2 - g'x over x >= least, by coordinates.
Unknowns bounded_minimum(const Gram& gram, const Unknowns& right, const Unknowns& least) {
  Unknowns x = Unknowns::Zero().cwiseMax(least);
  for (int sweep = 0; sweep < 20000; ++sweep) {
    double moved = 0;
    for (int k = 0; k < kUnknowns; ++k) {
      if (!(gram(k, k) > 0)) continue;
      const double next = std::max(least[k], x[k] + (right[k] - gram.row(k).dot(x)) / gram(k, k));
      moved = std::max(moved, std::abs(next - x[k]));
      x[k] = next;
    }
    if (moved < 1e-12) break;
  }
  return x;
}

// Does the same with sums of unknowns that are below a limit: sum over k of rows.col(i) x <=
// limit[i]. A sum that is not is brought to its limit by a stiff spring, and stays there.
Unknowns limited_minimum(Gram gram, Unknowns right, const Unknowns& least,
                         const Eigen::Matrix<double, kUnknowns, 2>& rows,
                         const Eigen::Vector2d& limit) {
  const double spring = 1e3 * gram.diagonal().maxCoeff();
  Unknowns x = bounded_minimum(gram, right, least);
  for (int i = 0; i < 2; ++i) {
    if (rows.col(i).dot(x) <= limit[i]) continue;
    gram += spring * rows.col(i) * rows.col(i).transpose();
    right += spring * limit[i] * rows.col(i);
    x = bounded_minimum(gram, right, least);
  }
  return x;
}

// The least excess over all vertices, that of the softest contact.
double least_excess(const runtime::AssetView& asset, const runtime::CouplingView& coupling) {
  double least = std::numeric_limits<double>::infinity();
  constexpr double kCorner[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int t = 0; t < asset.triangles; ++t)
    for (int k = 0; k < 3; ++k) {
      if (asset.covered[asset.corner(t, k)] == 0) continue;
      const runtime::ContactStiffness at = runtime::stiffness_at_end(asset, t, kCorner[k]);
      least = std::min(least, runtime::coupling_excess(coupling, at.along_N_m, at.across_N_m));
    }
  return least;
}

// Root mean square distance of the balls from their middle, and the largest radius.
double lever_m(const runtime::ToolShape& shape) {
  const auto centre = [&](int i) { return Eigen::Map<const Vec3>(shape.ball[i].centre_m); };
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < shape.balls; ++i) middle += centre(i) / shape.balls;
  double squares = 0, radius_m = 0;
  for (int i = 0; i < shape.balls; ++i) {
    squares += (centre(i) - middle).squaredNorm() / shape.balls;
    radius_m = std::max(radius_m, shape.ball[i].radius_m);
  }
  return radius_m + std::sqrt(squares);
}

}  // namespace

runtime::CouplingView identify_coupling(const runtime::AssetView& asset,
                                        const CouplingResidual& residual_of, double length_m) {
  Unknowns x = Unknowns::Zero();
  const auto left = [&](const Unknowns& at) { return residual_of(coupling_of(length_m, at)); };
  // Limits of the sum of all a_k, and of that of all b_k.
  constexpr int kScales = runtime::kCouplingScales;
  const auto most = [&](int k) {
    return 1 / least_excess(asset, coupling_of(length_m, Unknowns::Unit(k)));
  };
  const double own_m_N = most(0);
  const Eigen::Vector2d limit(kLimit, kLimit * most(kScales) / own_m_N);
  Eigen::Matrix<double, kUnknowns, 2> sums = Eigen::Matrix<double, kUnknowns, 2>::Ones();
  sums.col(0).tail(kScales).setZero();
  Eigen::VectorXd residual = left(x);
  const double alone = residual_of({}).norm();
  for (int step = 0; step < 12; ++step) {
    Eigen::MatrixXd slope(residual.size(), kUnknowns);
    for (int k = 0; k < kUnknowns; ++k) {
      const double by = 0.02 * own_m_N;  // a derivative by differences
      slope.col(k) = (left(x + by * Unknowns::Unit(k)) - residual) / by;
    }
    slope *= own_m_N;
    Gram gram = slope.transpose() * slope;
    gram.diagonal().array() += 1e-6 * gram.diagonal().maxCoeff();
    const Unknowns here = x / own_m_N;
    const Unknowns direction = own_m_N * limited_minimum(gram, -slope.transpose() * residual, -here,
                                                         sums, limit - sums.transpose() * here);
    double share = 1;
    bool is_better = false;
    for (int cut = 0; cut < 6 && !is_better; ++cut, share /= 2) {
      const Unknowns next = (x + share * direction).cwiseMax(0);
      const Eigen::VectorXd there = left(next);
      is_better = there.squaredNorm() < (1 - 1e-4 * share) * residual.squaredNorm();
      if (!is_better) continue;
      x = next;
      residual = there;
    }
    if (!is_better) break;
  }
  return residual.norm() < 0.9 * alone ? coupling_of(length_m, x) : runtime::CouplingView();
}

CouplingResidual coupling_residual(const runtime::AssetView& asset, const Samples& samples,
                                   double depth_m, const PlayedAs& played_as) {
  return [&asset, &samples, depth_m, played_as](const runtime::CouplingView& coupling) {
    const runtime::AssetView view = coupled_by(asset, coupling);
    const Replayed answered = follow(view, samples, depth_m, played_as);
    const Eigen::VectorXd scale_N = row_scales_N(samples);
    Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * samples.rows());
    for (Eigen::Index row = 0; row < samples.rows(); ++row) {
      if (!(scale_N[row] > 0)) continue;
      out.segment<3>(6 * row) =
          (answered.force_N.row(row) - samples.force.row(row)).transpose() / scale_N[row];
      const runtime::ToolShape shape = played_as ? played_as(row).shape : runtime::ToolShape();
      if (shape.balls > 1)
        out.segment<3>(6 * row + 3) =
            (answered.torque_Nm.row(row) - samples.torque.row(row)).transpose() /
            (scale_N[row] * lever_m(shape));
    }
    return out;
  };
}

}  // namespace palpate
