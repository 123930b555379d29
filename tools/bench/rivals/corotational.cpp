// (g): a coarse body that is solved at every tick.

#include "tools/bench/rivals/corotational.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::tools {
namespace {

// Of a triangle, exact for polynomials of degree 2.
constexpr double kTrianglePoint[3][3] = {
    {2.0 / 3, 1.0 / 6, 1.0 / 6}, {1.0 / 6, 2.0 / 3, 1.0 / 6}, {1.0 / 6, 1.0 / 6, 2.0 / 3}};

constexpr double kNear = 1.3;  // radii of the ball within which points may touch

// Edges of a tet from its first corner, as columns.
Mat3 edges_of(const Points& nodes, const Tets& tets, Eigen::Index tet) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (nodes.row(tets(tet, k + 1)) - nodes.row(tets(tet, 0))).transpose();
  return edges;
}

// Stiffness of a linear isotropic tet: V B^T D B.
Eigen::Matrix<double, 12, 12> tet_stiffness(const Mat3& edges, double young_Pa, double poisson) {
  const Mat3 inverse = edges.inverse();
  Eigen::Matrix<double, 4, 3> gradient;
  gradient.bottomRows<3>() = inverse;
  gradient.row(0) = -inverse.colwise().sum();
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

std::vector<CarriedPoint> carried_points(const Points& nodes, const Tets& tets,
                                         const Surface& surface, const Points& places,
                                         double within_m) {
  std::vector<Mat3> inverse;
  for (Eigen::Index t = 0; t < tets.rows(); ++t)
    inverse.push_back(edges_of(nodes, tets, t).inverse());
  const auto is_near = [&](const Vec3& corner) {
    return (places.rowwise() - corner.transpose()).rowwise().norm().minCoeff() <= within_m;
  };
  // The tet whose least weight is largest: the one that it lies in, or is least outside of.
  const auto carrier = [&](const Vec3& at) {
    CarriedPoint best;
    double most = -std::numeric_limits<double>::infinity();
    for (Eigen::Index t = 0; t < tets.rows(); ++t) {
      const Vec3 inner = inverse[static_cast<std::size_t>(t)] * (at - Vec3(nodes.row(tets(t, 0))));
      const Eigen::Vector4d weight(1 - inner.sum(), inner[0], inner[1], inner[2]);
      if (weight.minCoeff() > most)
        most = weight.minCoeff(), best.tet = static_cast<int>(t), best.weight = weight;
    }
    return best;
  };
  std::vector<CarriedPoint> out;
  for (const auto& triangle : surface.triangles.rowwise()) {
    Mat3 corner;
    for (int k = 0; k < 3; ++k) corner.col(k) = surface.vertices.row(triangle[k]).transpose();
    if (!is_near(corner.col(0)) && !is_near(corner.col(1)) && !is_near(corner.col(2))) continue;
    const double area_m2 =
        0.5 * (corner.col(1) - corner.col(0)).cross(corner.col(2) - corner.col(0)).norm();
    for (const auto& weight : kTrianglePoint) {
      out.push_back(carrier(corner * Eigen::Map<const Vec3>(weight)));
      out.back().area_m2 = area_m2 / 3;
    }
  }
  return out;
}

CorotationalBody::CorotationalBody(CoarseBody body, const CorotationalSettings& settings)
    : body_(std::move(body)), settings_(settings) {
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
  touch_.assign(body_.carried.size(), {});
  has_centre_ = false;
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

Vec3 CorotationalBody::place_of(std::size_t point) const {
  const CarriedPoint& carried = body_.carried[point];
  const auto tet = body_.tets.row(carried.tet);
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 4; ++k)
    place += carried.weight[k] * (body_.nodes.row(tet[k]) + u_.row(tet[k])).transpose();
  return place;
}

// Push of the ball on a point, and its stiffness. False where they do not touch.
bool CorotationalBody::add_touch(std::size_t point, const Vec3& centre_m, const Vec3& moved_m,
                                 Points& force) {
  const CarriedPoint& carried = body_.carried[point];
  const auto tet = body_.tets.row(carried.tet);
  CarriedTouch& touch = touch_[point];
  const Vec3 place = place_of(point), from_centre = place - centre_m;
  const double overlap_m = settings_.radius_m - from_centre.norm();
  const double spring_N_m = settings_.penalty_Pa_m * carried.area_m2;
  touch.side_N.setZero();
  if (!touch.is_pressed) touch.place_before_m = place - moved_m, touch.side_before_N.setZero();
  if (!(overlap_m > 0)) return false;
  const Vec3 normal = from_centre.normalized();
  const double pressed_N = spring_N_m * overlap_m, limit_N = settings_.friction * pressed_N;
  // A spring holds the point where it was on the ball.
  const Vec3 slip = place - touch.place_before_m - moved_m;
  Vec3 side = touch.side_before_N - spring_N_m * slip;
  side -= side.dot(normal) * normal;
  double side_N_m = spring_N_m;
  if (const double wanted_N = side.norm(); wanted_N > limit_N)
    side *= limit_N / wanted_N, side_N_m *= limit_N / wanted_N;
  touch.side_N = side;
  const Vec3 push = pressed_N * normal + side;
  const Mat3 along = normal * normal.transpose(),
             tangent = spring_N_m * along + side_N_m * (Mat3::Identity() - along);
  for (int a = 0; a < 4; ++a) {
    force.row(tet[a]) += carried.weight[a] * push.transpose();
    for (int b = 0; b < 4; ++b)
      block(tet[a], tet[b]) += carried.weight[a] * carried.weight[b] * tangent;
  }
  return true;
}

bool CorotationalBody::add_contact(const Vec3& centre_m, const Vec3& moved_m, Points& force) {
  bool touches = false;
  for (const std::size_t point : near_)
    touches = add_touch(point, centre_m, moved_m, force) || touches;
  return touches;
}

void CorotationalBody::remember_touches(const Vec3& centre_m) {
  for (const std::size_t point : near_) {
    CarriedTouch& touch = touch_[point];
    touch.place_before_m = place_of(point);
    touch.side_before_N = touch.side_N;
    touch.is_pressed = (touch.place_before_m - centre_m).norm() < settings_.radius_m;
  }
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
  const Vec3 moved_m = has_centre_ ? Vec3(centre_m - centre_m_) : Vec3::Zero();
  has_centre_ = true;
  centre_m_ = centre_m;
  near_.clear();
  for (std::size_t point = 0; point < touch_.size(); ++point)
    if ((place_of(point) - centre_m).norm() < kNear * settings_.radius_m) near_.push_back(point);
  if (near_.empty() && u_.isZero()) return Vec3::Zero();
  Points residual(u_.rows(), 3), step(u_.rows(), 3);
  for (int k = 0;; ++k) {
    residual.setZero();
    for (Block& each : blocks_) each.setZero();
    if (k == settings_.newton) break;
    if (!add_contact(centre_m, moved_m, residual) && u_.isZero()) return Vec3::Zero();
    add_elements(residual, true);
    for (std::size_t n = 0; n < body_.is_held.size(); ++n)
      if (body_.is_held[n]) residual.row(static_cast<Eigen::Index>(n)).setZero();
    solve(residual, step);
    u_ += step;
  }
  const bool touches = add_contact(centre_m, moved_m, residual);
  remember_touches(centre_m);
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
