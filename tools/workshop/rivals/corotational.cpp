// (g): a coarse body that is solved at every tick.

#include "tools/workshop/rivals/corotational.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

// Stiffness of a linear isotropic tet: V B^T D B.
Eigen::Matrix<double, 12, 12> tet_stiffness(const Mat3& edges, double young_Pa, double poisson) {
  const Eigen::Matrix<double, 4, 3> gradient = shape_gradients(edges.inverse());
  const double lambda = young_Pa * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const double mu = young_Pa / (2 * (1 + poisson)), volume = edges.determinant() / 6;
  Eigen::Matrix<double, 12, 12> K;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const Vec3 ga = gradient.row(a), gb = gradient.row(b);
      K.block<3, 3>(3 * a, 3 * b) =
          volume * (lambda * ga * gb.transpose() + mu * gb * ga.transpose() +
                    mu * ga.dot(gb) * Mat3::Identity());
    }
  return K;
}

// Turns q towards the rotation of F.
void follow_rotation(const Mat3& F, Eigen::Quaterniond& q) {
  for (int k = 0; k < 10; ++k) {
    const Mat3 R = q.matrix();
    Vec3 axis = Vec3::Zero();
    double scale = 1e-9;
    for (int j = 0; j < 3; ++j) {
      axis += R.col(j).cross(F.col(j));
      scale += std::abs(R.col(j).dot(F.col(j)));
    }
    axis /= scale;
    const double angle = axis.norm();
    if (angle < 1e-7) return;
    q = (Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis / angle)) * q).normalized();
  }
}

}  // namespace

CorotationalBody::CorotationalBody(CoarseBody body, const CorotationalSettings& settings)
    : body_(std::move(body)), settings_(settings), contact_(body_, settings.ball) {
  for (Eigen::Index t = 0; t < body_.tets.rows(); ++t) {
    const Mat3 edges = edges_of(body_.nodes, body_.tets, t);
    stiffness_.push_back(tet_stiffness(edges, body_.young_Pa[t], body_.poisson[t]));
    inverse_.push_back(edges.inverse());
  }
  make_pattern();
  start();
}

void CorotationalBody::start() {
  u_ = Points::Zero(body_.nodes.rows(), 3);
  turn_.assign(stiffness_.size(), Eigen::Quaterniond::Identity());
  contact_.start();
}

void CorotationalBody::make_pattern() {
  std::vector<std::vector<int>> row(static_cast<std::size_t>(body_.nodes.rows()));
  for (const auto& tet : body_.tets.rowwise())
    for (const int a : tet)
      for (const int b : tet) row[static_cast<std::size_t>(a)].push_back(b);
  row_start_ = {0};
  for (std::vector<int>& columns : row) {
    std::ranges::sort(columns);
    columns.erase(std::ranges::unique(columns).begin(), columns.end());
    column_.insert(column_.end(), columns.begin(), columns.end());
    row_start_.push_back(static_cast<int>(column_.size()));
  }
  blocks_.resize(column_.size());
}

CorotationalBody::Block& CorotationalBody::block(int row, int column) {
  const auto begin = column_.begin() + row_start_[static_cast<std::size_t>(row)];
  const auto end = column_.begin() + row_start_[static_cast<std::size_t>(row) + 1];
  return blocks_[static_cast<std::size_t>(std::lower_bound(begin, end, column) - column_.begin())];
}

std::size_t CorotationalBody::bytes() const {
  return stiffness_.size() * (sizeof(Stiffness) + sizeof(Mat3) + sizeof(Eigen::Quaterniond)) +
         blocks_.size() * (sizeof(Block) + sizeof(int)) +
         static_cast<std::size_t>(body_.nodes.rows()) * 6 * sizeof(double);
}

// Adds to `force` what the elements pull with and, where it is wanted, their stiffness to the
// blocks.
void CorotationalBody::add_elements(Points& force, bool with_stiffness) {
  for (std::size_t t = 0; t < stiffness_.size(); ++t) {
    const auto tet = body_.tets.row(static_cast<Eigen::Index>(t));
    Mat3 moved;
    for (int k = 0; k < 3; ++k)
      moved.col(k) = (body_.nodes.row(tet[k + 1]) + u_.row(tet[k + 1]) - body_.nodes.row(tet[0]) -
                      u_.row(tet[0]))
                         .transpose();
    follow_rotation(moved * inverse_[t], turn_[t]);
    const Mat3 R = turn_[t].matrix();
    Eigen::Matrix<double, 12, 1> strained;
    for (int a = 0; a < 4; ++a) {
      const Vec3 rest = body_.nodes.row(tet[a]), now = rest + Vec3(u_.row(tet[a]));
      strained.segment<3>(3 * a) = R.transpose() * now - rest;
    }
    const Eigen::Matrix<double, 12, 1> own = stiffness_[t] * strained;
    for (int a = 0; a < 4; ++a) {
      force.row(tet[a]) -= (R * own.segment<3>(3 * a)).transpose();
      for (int b = a; with_stiffness && b < 4; ++b) {
        const Mat3 turned = R * stiffness_[t].block<3, 3>(3 * a, 3 * b) * R.transpose();
        block(tet[a], tet[b]) += turned;
        if (b > a) block(tet[b], tet[a]) += turned.transpose();
      }
    }
  }
}

bool CorotationalBody::add_contact(Points& force) {
  return contact_.each_touch(u_, [&](const CarriedPoint& carried, const CarriedPush& push) {
    const auto tet = body_.tets.row(carried.tet);
    for (int a = 0; a < 4; ++a) {
      force.row(tet[a]) += carried.weight[a] * push.force.transpose();
      for (int b = 0; b < 4; ++b)
        block(tet[a], tet[b]) += carried.weight[a] * carried.weight[b] * push.tangent;
    }
  });
}

void CorotationalBody::multiply(const Points& x, Points& y) const {
  for (Eigen::Index row = 0; row < x.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    Vec3 sum = Vec3::Zero();
    for (int k = row_start_[r]; k < row_start_[r + 1]; ++k)
      sum += blocks_[static_cast<std::size_t>(k)] *
             x.row(column_[static_cast<std::size_t>(k)]).transpose();
    if (body_.is_held[r]) sum.setZero();
    y.row(row) = sum.transpose();
  }
}

// Conjugate gradients from zero, with the inverse of the diagonal blocks.
void CorotationalBody::solve(const Points& residual, Points& step) const {
  std::vector<Block> diagonal(body_.is_held.size());
  for (std::size_t r = 0; r < diagonal.size(); ++r)
    for (int k = row_start_[r]; k < row_start_[r + 1]; ++k)
      if (column_[static_cast<std::size_t>(k)] == static_cast<int>(r))
        diagonal[r] = blocks_[static_cast<std::size_t>(k)].inverse();
  const auto scaled = [&](const Points& r, Points& z) {
    for (Eigen::Index n = 0; n < r.rows(); ++n)
      z.row(n) = (diagonal[static_cast<std::size_t>(n)] * r.row(n).transpose()).transpose();
  };
  Points r = residual, z = r, p, q = r;
  step.setZero();
  scaled(r, z);
  p = z;
  double rz = r.cwiseProduct(z).sum();
  const double goal = settings_.tolerance * settings_.tolerance * r.squaredNorm();
  for (int k = 0; k < settings_.solver && r.squaredNorm() > goal; ++k) {
    multiply(p, q);
    const double alpha = rz / p.cwiseProduct(q).sum();
    step += alpha * p;
    r -= alpha * q;
    scaled(r, z);
    const double next = r.cwiseProduct(z).sum();
    p = z + (next / rz) * p;
    rz = next;
  }
}

Vec3 CorotationalBody::force(const Vec3& centre_m) {
  if (!contact_.gather(u_, centre_m) && u_.isZero()) return Vec3::Zero();
  Points residual(u_.rows(), 3), step(u_.rows(), 3);
  for (int k = 0;; ++k) {
    residual.setZero();
    for (Block& each : blocks_) each.setZero();
    if (k == settings_.newton) break;
    if (!add_contact(residual) && u_.isZero()) return Vec3::Zero();
    add_elements(residual, true);
    for (std::size_t n = 0; n < body_.is_held.size(); ++n)
      if (body_.is_held[n]) residual.row(static_cast<Eigen::Index>(n)).setZero();
    solve(residual, step);
    u_ += step;
  }
  const bool touches = add_contact(residual);
  contact_.remember(u_);
  if (!touches) return Vec3::Zero();
  // What the body stands against: the penalty's own force is off by more where a step is left.
  residual.setZero();
  add_elements(residual, false);
  Vec3 sum = Vec3::Zero();
  for (std::size_t n = 0; n < body_.is_held.size(); ++n)
    if (!body_.is_held[n]) sum -= residual.row(static_cast<Eigen::Index>(n)).transpose();
  return sum;
}

}  // namespace palpate::tools
