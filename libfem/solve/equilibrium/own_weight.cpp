#include "libfem/solve/equilibrium/own_weight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "libfem/elements/cell_integrals.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/anderson.hpp"
#include "libfem/solve/factor/schur_factor.hpp"

namespace palpate::fem {
namespace {

constexpr double kResidual = 1e-9;  // of the weight, 2-norm over the free nodes
constexpr int kMaxNewton = 40, kMaxCuts = 10;
constexpr double kKept = 0.1;  // a factor serves while a step brings the residual down so far
constexpr double kShortest = 1.0 / 64;  // load step
constexpr int kMaxBackward = 30;        // corrections of the shape at rest
constexpr int kMixing = 5;

/// Newton's method for a body and its weight; the factor's order serves every shape of one mesh.
class WeightSolver {
 public:
  explicit WeightSolver(const WeightedBody& body) : of_(body) {}

  /// Equilibrium of `mesh` at a share of its weight, sought from u, which takes it. False where
  /// there is none near.
  bool settle(const QuadraticMesh& mesh, double share, Points& u, SchurFactor& factor,
              int& solves) {
    elastic_.emplace(mesh, of_.materials, of_.region_at);
    bed_ = ElasticBed(mesh, of_.bed_at);
    weight_N_ = share * weight_N(mesh, of_.weight);
    SymmetricBlockMatrix K = elastic_->pattern();
    double scale_N = 0;
    for (Eigen::Index n = 0; n < u.rows(); ++n)
      if (elastic_->free_index()[n] >= 0) scale_N += weight_N_.row(n).squaredNorm();
    scale_N = std::sqrt(scale_N);
    Eigen::VectorXd residual, step;
    double energy = evaluate(u, residual), before = 0;
    bool is_factored = false;
    for (int iteration = 0; iteration < kMaxNewton && std::isfinite(energy); ++iteration) {
      if (residual.norm() <= kResidual * scale_N) return true;
      if (!is_factored || residual.norm() > kKept * before) {
        Points unused = Points::Zero(u.rows(), 3);
        double geometric = 1;  // made less where the tangent is not positive definite
        for (is_factored = false; !is_factored && geometric >= 0;) {
          K.set_zero();
          elastic_->add_stiffness(u, geometric, unused, K, kMaxPressure);
          bed_.add_stiffness(elastic_->free_index(), K);
          is_factored = factor.factor(K, {});
          if (!is_factored) geometric -= 0.5;
        }
        if (!is_factored) return false;
      }
      before = residual.norm();
      factor.solve(residual, step);
      ++solves;
      const double slope = residual.dot(step);
      const Points start = u;
      const double energy_before = energy;
      double length = 1;
      for (int cut = 0;; ++cut, length /= 2) {
        if (cut == kMaxCuts) return false;
        u = moved(start, length * step);
        energy = evaluate(u, residual);
        // Near the solution the fall of the energy drowns in rounding.
        if (std::isfinite(energy) &&
            (residual.norm() < 0.5 * before || energy < energy_before - 1e-4 * length * slope))
          break;
      }
    }
    return false;
  }

 private:
  static constexpr double kMaxPressure = 2;  // EquilibriumOptions::max_pressure

  Points moved(const Points& u, const Eigen::VectorXd& by) const {
    Points out = u;
    for (Eigen::Index n = 0; n < u.rows(); ++n)
      if (const std::int32_t i = elastic_->free_index()[n]; i >= 0)
        out.row(n) += by.segment<3>(3 * i).transpose();
    return out;
  }

  // Energy [J] at u, and what is out of balance on the free nodes [N].
  double evaluate(const Points& u, Eigen::VectorXd& residual) const {
    Points force = -weight_N_;
    double energy = elastic_->add_force(u, force) + bed_.add_force(u, force);
    energy -= weight_N_.cwiseProduct(u).sum();
    residual.setZero(
        3 * (1 + *std::max_element(elastic_->free_index().begin(), elastic_->free_index().end())));
    for (Eigen::Index n = 0; n < u.rows(); ++n)
      if (const std::int32_t i = elastic_->free_index()[n]; i >= 0)
        residual.segment<3>(3 * i) = -force.row(n).transpose();
    return energy;
  }

  const WeightedBody& of_;
  std::optional<ElasticBody> elastic_;
  ElasticBed bed_;
  Points weight_N_;
};

// Calls reach(share) with growing shares of the load, in steps halved where it says false. Returns
// the share that was reached.
template <class Reach>
double in_load_steps(Reach&& reach) {
  double done = 0, step = 1;
  while (done < 1) {
    const double next = done + step > 1 - 1e-9 ? 1 : done + step;
    if (reach(next)) {
      done = next;
      continue;
    }
    step = (next - done) / 2;
    if (step < kShortest) break;
  }
  return done;
}

}  // namespace

Points weight_N(const QuadraticMesh& mesh, const OwnWeight& weight) {
  if (!weight.is_there()) return {};
  Points out = Points::Zero(mesh.nodes.rows(), 3);
  for (const ElementPoint& point : element_points())
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
      Mat3 jacobian = Mat3::Zero();
      for (int a = 0; a < kElementNodes; ++a)
        jacobian += mesh.nodes.row(mesh.tets(t, a)).transpose() * point.by_xi.row(a);
      const Vec3 force = weight.density_kg_m3 * std::abs(jacobian.determinant()) * point.weight /
                         6 * weight.acceleration_m_s2;
      for (int a = 0; a < kElementNodes; ++a)
        out.row(mesh.tets(t, a)) += point.shape[a] * force.transpose();  // (M13h)
    }
  return out;
}

LoadedSearch bend_under_weight(const WeightedBody& body, QuadraticMesh& mesh) {
  LoadedSearch out;
  SchurFactor factor;
  WeightSolver solver(body);
  Points u = Points::Zero(mesh.nodes.rows(), 3), velocity = u;
  double done = 0;
  out.share = in_load_steps([&](double share) {
    Points next = u + (share - done) * velocity;
    if (!solver.settle(mesh, share, next, factor, out.solves)) return false;
    velocity = (next - u) / (share - done);
    u = std::move(next);
    done = share;
    return true;
  });
  if (out.is_found()) mesh.loaded = mesh.nodes + u;
  return out;
}

LoadedSearch unbend(const WeightedBody& body, double tolerance_m, const Points& sag,
                    QuadraticMesh& mesh) {
  LoadedSearch out;
  const Points given = mesh.nodes;
  QuadraticMesh trial = mesh;
  if (!body.regions_at_rest) trial.loaded = given;
  SchurFactor factor;
  WeightSolver solver(body);
  Points known = Points::Zero(given.rows(), 3), u;  // sag at the share that is done
  double done = 0;
  const auto reach = [&](double share) {
    Points guess = done > 0         ? Points(share / done * known)
                   : sag.rows() > 0 ? Points(share * sag)
                                    : known;
    trial.nodes = given - guess;
    AndersonMixing mixing(kMixing);
    double best_m = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kMaxBackward; ++k) {
      u = given - trial.nodes;
      if (!solver.settle(trial, share, u, factor, out.solves)) return false;
      const Points off = trial.nodes + u - given;
      out.residual_m = off.rowwise().norm().maxCoeff();
      if (out.residual_m <= tolerance_m) {
        known = given - trial.nodes;
        done = share;
        return true;
      }
      if (out.residual_m > 10 * best_m) return false;
      best_m = std::min(best_m, out.residual_m);
      const Eigen::VectorXd back =
          -Eigen::Map<const Eigen::VectorXd>(off.data(), off.size());  // (M13i)
      const Eigen::VectorXd step = mixing.mix(back, back);
      mixing.took(step);
      trial.nodes += Eigen::Map<const Points>(step.data(), off.rows(), 3);
    }
    return false;
  };
  out.share = in_load_steps(reach);
  if (!out.is_found()) return out;
  mesh.nodes = trial.nodes;
  mesh.loaded = trial.nodes + u;
  return out;
}

}  // namespace palpate::fem
