#include "libfem/mesh/surface/geodesic.hpp"

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace palpate {
namespace {

// When a plane front that passes a and b at these distances reaches c, from within the triangle;
// else along an edge.
double front_at(const Vec3& a, const Vec3& b, const Vec3& c, double at_a, double at_b) {
  const Vec3 to_a = a - c, to_b = b - c;
  const double along_edge = std::min(at_a + to_a.norm(), at_b + to_b.norm());
  // The front's direction n, |n| = 1, lies in the plane of the triangle: V' n = t - t_c 1.
  Eigen::Matrix2d gram;
  gram << to_a.dot(to_a), to_a.dot(to_b), to_a.dot(to_b), to_b.dot(to_b);
  if (!(gram.determinant() > 1e-12 * gram(0, 0) * gram(1, 1))) return along_edge;
  const Eigen::Matrix2d inverse = gram.inverse();
  const Eigen::Vector2d one = Eigen::Vector2d::Ones(), at(at_a, at_b);
  const double p = one.dot(inverse * one), q = one.dot(inverse * at), r = at.dot(inverse * at) - 1;
  const double root = q * q - p * r;
  if (root < 0) return along_edge;
  const double at_c = (q + std::sqrt(root)) / p;
  // The way back from c leaves the triangle between a and b.
  const Eigen::Vector2d weight = inverse * (at - at_c * one);
  return weight.maxCoeff() < 0 ? std::min(at_c, along_edge) : along_edge;
}

}  // namespace

Eigen::VectorXd geodesic_distance_m(const Surface& surface, const SurfacePoint& from) {
  const auto vertices = surface.vertices.rows();
  std::vector<std::vector<Eigen::Index>> around(static_cast<std::size_t>(vertices));
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      around[static_cast<std::size_t>(surface.triangles(f, k))].push_back(f);
  Eigen::VectorXd distance =
      Eigen::VectorXd::Constant(vertices, std::numeric_limits<double>::infinity());
  std::vector<char> is_settled(static_cast<std::size_t>(vertices), 0);
  using Item = std::pair<double, std::int32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> front;
  const auto offer = [&](std::int32_t v, double value) {
    if (!(value < distance[v])) return;
    distance[v] = value;
    front.emplace(value, v);
  };
  // A round start needs more than its own triangle to look plane: its neighbours', too.
  for (int k = 0; k < 3; ++k)
    for (const Eigen::Index f :
         around[static_cast<std::size_t>(surface.triangles(from.triangle, k))])
      for (int j = 0; j < 3; ++j) {
        const std::int32_t v = surface.triangles(f, j);
        offer(v, (surface.vertices.row(v).transpose() - from.position).norm());
      }
  while (!front.empty()) {
    const auto [value, settled] = front.top();
    front.pop();
    if (is_settled[static_cast<std::size_t>(settled)]) continue;
    is_settled[static_cast<std::size_t>(settled)] = 1;
    for (const Eigen::Index f : around[static_cast<std::size_t>(settled)])
      for (int k = 0; k < 3; ++k) {
        const std::int32_t c = surface.triangles(f, k), a = surface.triangles(f, (k + 1) % 3),
                           b = surface.triangles(f, (k + 2) % 3);
        if (is_settled[static_cast<std::size_t>(c)]) continue;
        const Vec3 at_c = surface.vertices.row(c), at_a = surface.vertices.row(a),
                   at_b = surface.vertices.row(b);
        const bool has_a = is_settled[static_cast<std::size_t>(a)] != 0,
                   has_b = is_settled[static_cast<std::size_t>(b)] != 0;
        if (has_a && has_b)
          offer(c, front_at(at_a, at_b, at_c, distance[a], distance[b]));
        else if (has_a)
          offer(c, distance[a] + (at_c - at_a).norm());
        else if (has_b)
          offer(c, distance[b] + (at_c - at_b).norm());
      }
  }
  return distance;
}

}  // namespace palpate
