#pragma once

#include <vector>

#include <Eigen/Core>

// Natural-neighbour coordinates (Sibson 1981, A brief description of natural neighbour
// interpolation) by clipping, as the alternative that area interpolation is measured against.
namespace palpate::testing_refine {

using Polygon = std::vector<Eigen::Vector2d>;

/// The part of a convex polygon that is no farther from `near` than from `far`.
inline Polygon nearer_part(const Polygon& polygon, const Eigen::Vector2d& near,
                           const Eigen::Vector2d& far) {
  const Eigen::Vector2d normal = far - near, middle = 0.5 * (near + far);
  const auto excess = [&](const Eigen::Vector2d& p) { return normal.dot(p - middle); };
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ea = excess(a), eb = excess(b);
    if (ea <= 0) kept.push_back(a);
    if ((ea < 0 && eb > 0) || (ea > 0 && eb < 0)) kept.push_back(a + (b - a) * (ea / (ea - eb)));
  }
  return kept;
}

inline double area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

/// Weights of the points at a place within their hull: the share of its own Voronoi cell that it
/// takes from each. Not negative, sum 1, exact for linear fields, C1 but at the points.
/// reach: half the side of a box that holds the cell.
inline std::vector<double> natural_weights(const std::vector<Eigen::Vector2d>& points,
                                           const Eigen::Vector2d& at, double reach) {
  Polygon cell{at + Eigen::Vector2d(-reach, -reach), at + Eigen::Vector2d(reach, -reach),
               at + Eigen::Vector2d(reach, reach), at + Eigen::Vector2d(-reach, reach)};
  for (const Eigen::Vector2d& p : points) cell = nearer_part(cell, at, p);
  std::vector<double> weights;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Polygon stolen = cell;
    for (std::size_t j = 0; j < points.size() && !stolen.empty(); ++j)
      if (j != i) stolen = nearer_part(stolen, points[i], points[j]);
    weights.push_back(stolen.size() > 2 ? area(stolen) : 0);
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace palpate::testing_refine
