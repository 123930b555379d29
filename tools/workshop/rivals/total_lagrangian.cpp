// (g): the body that is stepped explicitly.

#include "tools/workshop/rivals/total_lagrangian.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

constexpr int kPowerIterations = 60;
constexpr double kSmall_m = 1e-7;  // displacement of a difference of forces

}  // namespace

ExplicitBody::ExplicitBody(CoarseBody body, const ExplicitSettings& settings)
    : body_(std::move(body)), settings_(settings), contact_(body_, settings.ball) {
  mass_kg_ = Eigen::VectorXd::Zero(body_.nodes.rows());
  for (Eigen::Index t = 0; t < body_.tets.rows(); ++t) {
    const Mat3 edges = edges_of(body_.nodes, body_.tets, t);
    const double young = body_.young_Pa[t], poisson = body_.poisson[t];
    element_.push_back({shape_gradients(edges.inverse()), edges.determinant() / 6,
                        young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))});
    for (const int node : body_.tets.row(t))
      mass_kg_[node] += 0.25 * settings_.density_kg_m3 * element_.back().volume_m3;
  }
  const double stable_s = 2 / std::sqrt(highest_squared_Hz());
  steps_ = static_cast<int>(std::ceil(settings_.tick_s / (settings_.step_of_stable * stable_s)));
  start();
}

void ExplicitBody::start() {
  u_ = before_ = Points::Zero(body_.nodes.rows(), 3);
  contact_.start();
}

std::size_t ExplicitBody::bytes() const {
  return element_.size() * (sizeof(ExplicitElement) + 4 * sizeof(std::int32_t)) +
         static_cast<std::size_t>(body_.nodes.rows()) * 13 * sizeof(double);
}

// What the elements pull their nodes with: S = mu J^(-2/3) (I - I1/3 C^-1) + K J (J - 1) C^-1.
void ExplicitBody::add_elements(const Points& u, Points& force) const {
  for (std::size_t t = 0; t < element_.size(); ++t) {
    const ExplicitElement& element = element_[t];
    const auto tet = body_.tets.row(static_cast<Eigen::Index>(t));
    Mat3 F = Mat3::Identity();
    for (int a = 0; a < 4; ++a) F += u.row(tet[a]).transpose() * element.gradient.row(a);
    const double J = std::max(0.05, F.determinant());
    const Mat3 turned = F.inverse().transpose();  // F S = P without forming C
    const Mat3 P = element.shear_Pa / std::cbrt(J * J) * (F - F.squaredNorm() / 3 * turned) +
                   element.bulk_Pa * J * (J - 1) * turned;
    for (int a = 0; a < 4; ++a)
      force.row(tet[a]) -=
          element.volume_m3 * (P * element.gradient.row(a).transpose()).transpose();
  }
}

// Largest eigenvalue of M^-1 K, by powers; K of elements at rest and of a ball on every point.
double ExplicitBody::highest_squared_Hz() {
  Points mode(body_.nodes.rows(), 3);
  for (Eigen::Index i = 0; i < mode.size(); ++i) mode.data()[i] = std::cos(double(i * i % 1013));
  double squared = 0;
  for (int k = 0; k < kPowerIterations; ++k) {
    for (Eigen::Index n = 0; n < mode.rows(); ++n)
      if (body_.is_held[static_cast<std::size_t>(n)]) mode.row(n).setZero();
    mode *= kSmall_m / mode.norm();
    Points pulled = Points::Zero(mode.rows(), 3);
    add_elements(mode, pulled);
    pulled = -pulled;
    for (const CarriedPoint& carried : body_.carried) {
      const auto tet = body_.tets.row(carried.tet);
      Vec3 moved = Vec3::Zero();
      for (int a = 0; a < 4; ++a) moved += carried.weight[a] * mode.row(tet[a]).transpose();
      for (int a = 0; a < 4; ++a)
        pulled.row(tet[a]) +=
            carried.weight[a] * carried.area_m2 * settings_.ball.penalty_Pa_m * moved.transpose();
    }
    pulled.array().colwise() /= mass_kg_.array();
    squared = pulled.norm() / kSmall_m;
    mode = pulled;
  }
  return squared;
}

Vec3 ExplicitBody::force(const Vec3& centre_m) {
  contact_.gather(u_, centre_m);
  Points force(u_.rows(), 3);
  Vec3 sum = Vec3::Zero();
  const double step_s = settings_.tick_s / steps_, held_back = 0.5 * settings_.damping_Hz * step_s;
  for (int k = 0; k < steps_; ++k) {
    force.setZero();
    sum.setZero();
    contact_.each_touch(u_, [&](const CarriedPoint& carried, const CarriedPush& push) {
      const auto tet = body_.tets.row(carried.tet);
      for (int a = 0; a < 4; ++a) force.row(tet[a]) += carried.weight[a] * push.force.transpose();
      sum += push.force;
    });
    add_elements(u_, force);
    for (Eigen::Index n = 0; n < u_.rows(); ++n) {
      if (body_.is_held[static_cast<std::size_t>(n)]) continue;
      const Vec3 now = u_.row(n), last = before_.row(n);
      before_.row(n) = now.transpose();
      u_.row(n) =
          ((step_s * step_s / mass_kg_[n] * Vec3(force.row(n)) + 2 * now - (1 - held_back) * last) /
           (1 + held_back))
              .transpose();
    }
  }
  contact_.remember(u_);
  return sum;
}

}  // namespace palpate::tools
