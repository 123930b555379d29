#include "libfem/mesh/grade/smooth_surface.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
SmoothSurface::SmoothSurface(Surface surface) : surface_(std::move(surface)) {
  const Eigen::Index count = surface_.triangles.rows();
  facet_normal_.resize(count, 3);
  for (std::int32_t f = 0; f < count; ++f) {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const Vec3 normal = (b - a).cross(c - a);
    const double length = normal.norm();
    facet_normal_.row(f) = length > 0 ? Vec3(normal / length) : Vec3::Zero();
  }
  if (facet_normal_.isZero(0))
    throw Error("surface", "no triangle has an area", "Give a surface, not lines or points.");
  triangle_boxes_ = triangle_boxes(surface_);
  average_corner_normals(find_neighbours());
}

DisjointSets SmoothSurface::find_neighbours() {
  DisjointSets fans(surface_.triangles.size());
  const double crease_cosine = std::cos(kCreaseAngle_rad);
  smooth_neighbour_ = Triangles::Constant(surface_.triangles.rows(), 3, -1);
  for_each_edge(sorted_sides(surface_.triangles), [&](auto begin, auto end) {
    const TriangleSide &f = *begin, &g = *(end - 1);
    const Vec3 normal_f = facet_normal_.row(f.face), normal_g = facet_normal_.row(g.face);
    // A triangle without area has no say: it joins what it touches.
    const bool is_smooth = end - begin == 2 && (normal_f.isZero(0) || normal_g.isZero(0) ||
                                                normal_f.dot(normal_g) >= crease_cosine);
    if (is_smooth) {
      smooth_neighbour_(f.face, f.corner) = g.face;
      smooth_neighbour_(g.face, g.corner) = f.face;
      join_fans(surface_.triangles, f, g, fans);
    } else {
      crease_.push_back({f.low, f.high});
    }
  });
  crease_boxes_ = boxes_of(surface_.vertices, rows_of(crease_));
  return fans;
}

void SmoothSurface::average_corner_normals(DisjointSets fans) {
  const auto& triangles = surface_.triangles;
  Points sum = Points::Zero(triangles.size(), 3);
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vec3 e1 = corner(f, (k + 1) % 3) - corner(f, k);
      const Vec3 e2 = corner(f, (k + 2) % 3) - corner(f, k);
      const double angle = std::atan2(e1.cross(e2).norm(), e1.dot(e2));
      sum.row(fans.find(3 * f + k)) += angle * facet_normal_.row(f);
    }
  corner_normal_.resize(triangles.size(), 3);
  for (std::int32_t c = 0; c < triangles.size(); ++c) {
    const Vec3 total = sum.row(fans.find(c));
    const double length = total.norm();
    corner_normal_.row(c) = length > 0 ? Vec3(total / length) : Vec3(facet_normal_.row(c / 3));
  }
}

template <class Accept>
std::optional<SurfaceHit> SmoothSurface::closest_where(const Vec3& point, Accept&& accept) const {
  const auto found = closest_point(surface_, triangle_boxes_, point,
                                   std::numeric_limits<double>::infinity(), accept);
  if (!found) return std::nullopt;
  SurfaceHit hit;
  hit.triangle = found->triangle;
  hit.weights = found->weight;
  hit.on_facet = found->position;
  hit.position = lifted(hit.triangle, hit.weights);
  hit.normal = normal(hit.triangle, hit.weights);
  hit.distance_m = found->distance_m;
  return hit;
}

SurfaceHit SmoothSurface::closest(const Vec3& point) const {
  // Some triangle has an area (checked on construction), so there is always a hit for finite
  // points.
  const auto has_area = [&](const SurfacePoint& at) {
    return !facet_normal_.row(at.triangle).isZero(0);
  };
  return closest_where(point, has_area).value_or(SurfaceHit{});
}

std::optional<SurfaceHit> SmoothSurface::closest(const Vec3& point, const Vec3& direction,
                                                 double min_cosine) const {
  const Vec3 unit = direction.stableNormalized();
  return closest_where(point, [&](const SurfacePoint& at) {
    const auto facet = facet_normal_.row(at.triangle);
    return !facet.isZero(0) && facet.dot(unit) >= min_cosine;
  });
}

std::optional<Vec3> SmoothSurface::closest_crease(const Vec3& point, double within_m) const {
  std::optional<Vec3> hit;
  double squared_best = within_m * within_m;
  crease_boxes_.visit_nearest(point, squared_best, [&](std::int32_t e, double& best) {
    const Vec3 a = surface_.vertices.row(crease_[e][0]), b = surface_.vertices.row(crease_[e][1]);
    const Vec3 nearest = a + nearest_on_segment(point, a, b) * (b - a);
    const double squared = (nearest - point).squaredNorm();
    if (squared > best || (hit && squared == best)) return;
    best = squared;
    hit = nearest;
  });
  return hit;
}

Vec3 SmoothSurface::lifted(std::int32_t triangle, const Vec3& weights) const {
  const Vec3 p = weights[0] * corner(triangle, 0) + weights[1] * corner(triangle, 1) +
                 weights[2] * corner(triangle, 2);
  Vec3 out = p;
  for (int k = 0; k < 3; ++k) {
    const Vec3 normal_k = corner_normal_.row(3 * triangle + k);
    out -= 0.5 * weights[k] * (p - corner(triangle, k)).dot(normal_k) * normal_k;
  }
  return out;
}

Vec3 SmoothSurface::normal(std::int32_t triangle, const Vec3& weights) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) sum += weights[k] * corner_normal_.row(3 * triangle + k).transpose();
  const double length = sum.norm();
  return length > 0 ? Vec3(sum / length) : Vec3(facet_normal_.row(triangle));
}

namespace {

constexpr int kTerms = 10;  // 1, x, y, x^2, xy, y^2 and the four cubics

struct Sample {
  Vec3 position;
  double area;
};

// Height over a frame whose third axis is roughly the normal; columns x, y, z.
Eigen::Matrix<double, 1, kTerms> terms(double x, double y) {
  Eigen::Matrix<double, 1, kTerms> row;
  row << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return row;
}

Mat3 frame_about(const Vec3& normal) {
  Mat3 frame;
  frame.col(2) = normal;
  frame.col(0) = normal.unitOrthogonal();
  frame.col(1) = normal.cross(frame.col(0));
  return frame;
}

// Weight 1 at the centre, 0 with zero slope at the rim: samples come and go without a jump.
double window(double distance, double radius) {
  const double t = distance / radius;
  return t < 1 ? (1 - t * t) * (1 - t * t) : 0;
}

}  // namespace

std::vector<std::int32_t> SmoothSurface::patch_around(const SurfaceHit& centre,
                                                      double radius_m) const {
  std::vector<std::int32_t> patch{centre.triangle};
  std::vector<char> is_visited(surface_.triangles.rows(), 0);
  is_visited[centre.triangle] = 1;
  for (std::size_t i = 0; i < patch.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t next = smooth_neighbour_(patch[i], k);
      if (next < 0 || is_visited[next]) continue;
      is_visited[next] = 1;
      const Vec3 a = corner(patch[i], k), b = corner(patch[i], (k + 1) % 3);
      const double along = nearest_on_segment(centre.on_facet, a, b);
      if ((a + along * (b - a) - centre.on_facet).norm() < radius_m) patch.push_back(next);
    }
  return patch;
}

Mat3 SmoothSurface::normal_gradient(const SurfaceHit& centre, double radius_m) const {
  std::vector<Sample> samples;
  for (const std::int32_t f : patch_around(centre, radius_m)) {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    // A triangle far larger than the patch is sampled no finer.
    // Twelve or more samples a fit of 10 terms even at a corner.
    const int split = std::clamp(static_cast<int>(std::ceil(4.0 * longest / radius_m)), 1, 32);
    const double area = 0.5 * (b - a).cross(c - a).norm() / (split * split);
    // Centres of the split^2 small triangles, upright ones first: a midpoint rule over the facet.
    for (int i = 0; i < split; ++i)
      for (int j = 0; i + j < split; ++j)
        for (int upside = 0; upside < (i + j + 1 < split ? 2 : 1); ++upside) {
          const double third = upside == 0 ? 1.0 / 3 : 2.0 / 3;
          const double u = (i + third) / split, v = (j + third) / split;
          samples.push_back({lifted(f, {1 - u - v, u, v}), area});
        }
  }

  // The second pass fits about the first one's own normal, where the height has no slope.
  Mat3 frame = frame_about(centre.normal);
  Mat3 gradient = Mat3::Zero();
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::MatrixXd matrix(samples.size(), kTerms);
    Eigen::VectorXd height(matrix.rows());
    for (Eigen::Index s = 0; s < matrix.rows(); ++s) {
      const Sample& sample = samples[s];
      const Vec3 local = frame.transpose() * (sample.position - centre.position) / radius_m;
      const double weight = std::sqrt(sample.area * window(local.norm(), 1));
      matrix.row(s) = weight * terms(local[0], local[1]);
      height[s] = weight * local[2];
    }
    const Eigen::VectorXd fit = matrix.completeOrthogonalDecomposition().solve(height);
    Eigen::Matrix2d hessian;
    hessian << 2 * fit[3], fit[4], fit[4], 2 * fit[5];
    const auto tangents = frame.leftCols<2>();
    gradient = tangents * (hessian / radius_m) * tangents.transpose();
    frame = frame_about((frame * Vec3(-fit[1], -fit[2], 1)).normalized());
  }
  const Mat3 along = Mat3::Identity() - centre.normal * centre.normal.transpose();
  const Mat3 tangential = along * gradient * along;
  return 0.5 * (tangential + tangential.transpose());
}

}  // namespace palpate::fem
