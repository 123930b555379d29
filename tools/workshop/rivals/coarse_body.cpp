// What coarse bodies share that are solved at every tick.

#include "tools/workshop/rivals/coarse_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::tools {
namespace {

// Of a triangle, exact for polynomials of degree 2.
constexpr double kTrianglePoint[3][3] = {
    {2.0 / 3, 1.0 / 6, 1.0 / 6}, {1.0 / 6, 2.0 / 3, 1.0 / 6}, {1.0 / 6, 1.0 / 6, 2.0 / 3}};

constexpr double kNear = 1.3;  // radii of the ball within which points may touch

}  // namespace

Mat3 edges_of(const Points& nodes, const Tets& tets, Eigen::Index tet) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (nodes.row(tets(tet, k + 1)) - nodes.row(tets(tet, 0))).transpose();
  return edges;
}

Eigen::Matrix<double, 4, 3> shape_gradients(const Mat3& inverse_edges) {
  Eigen::Matrix<double, 4, 3> gradient;
  gradient.bottomRows<3>() = inverse_edges;
  gradient.row(0) = -inverse_edges.colwise().sum();
  return gradient;
}

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

CarriedContact::CarriedContact(const CoarseBody& body, const BallContact& ball)
    : body_(body), ball_(ball) {
  start();
}

void CarriedContact::start() {
  touch_.assign(body_.carried.size(), {});
  near_.clear();
  has_centre_ = false;
}

bool CarriedContact::gather(const Points& u, const Vec3& centre_m) {
  moved_m_ = has_centre_ ? Vec3(centre_m - centre_m_) : Vec3::Zero();
  has_centre_ = true;
  centre_m_ = centre_m;
  near_.clear();
  for (std::size_t point = 0; point < touch_.size(); ++point)
    if ((place_of(point, u) - centre_m).norm() < kNear * ball_.radius_m) near_.push_back(point);
  return !near_.empty();
}

Vec3 CarriedContact::place_of(std::size_t point, const Points& u) const {
  const CarriedPoint& carried = body_.carried[point];
  const auto tet = body_.tets.row(carried.tet);
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 4; ++k)
    place += carried.weight[k] * (body_.nodes.row(tet[k]) + u.row(tet[k])).transpose();
  return place;
}

bool CarriedContact::push_on(std::size_t point, const Points& u, CarriedPush& push) {
  CarriedTouch& touch = touch_[point];
  const Vec3 place = place_of(point, u), from_centre = place - centre_m_;
  const double overlap_m = ball_.radius_m - from_centre.norm();
  const double spring_N_m = ball_.penalty_Pa_m * body_.carried[point].area_m2;
  touch.side_N.setZero();
  if (!touch.is_pressed) touch.place_before_m = place - moved_m_, touch.side_before_N.setZero();
  if (!(overlap_m > 0)) return false;
  const Vec3 normal = from_centre.normalized();
  const double pressed_N = spring_N_m * overlap_m, limit_N = ball_.friction * pressed_N;
  // A spring holds the point where it was on the ball.
  const Vec3 slip = place - touch.place_before_m - moved_m_;
  Vec3 side = touch.side_before_N - spring_N_m * slip;
  side -= side.dot(normal) * normal;
  double side_N_m = spring_N_m;
  if (const double wanted_N = side.norm(); wanted_N > limit_N)
    side *= limit_N / wanted_N, side_N_m *= limit_N / wanted_N;
  touch.side_N = side;
  const Mat3 along = normal * normal.transpose();
  push.force = pressed_N * normal + side;
  push.tangent = spring_N_m * along + side_N_m * (Mat3::Identity() - along);
  return true;
}

void CarriedContact::remember(const Points& u) {
  for (const std::size_t point : near_) {
    CarriedTouch& touch = touch_[point];
    touch.place_before_m = place_of(point, u);
    touch.side_before_N = touch.side_N;
    touch.is_pressed = (touch.place_before_m - centre_m_).norm() < ball_.radius_m;
  }
}

}  // namespace palpate::tools
