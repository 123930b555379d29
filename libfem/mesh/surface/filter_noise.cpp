#include "libfem/mesh/surface/surface.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {
namespace {

constexpr double kAlike = 0.6;  // distance of unit normals at which a neighbour counts 0.6 of full

using Around = std::vector<std::vector<std::int32_t>>;

// Triangles that share a vertex with each, itself left out.
Around neighbours_of(const Surface& surface, const Around& around) {
  Around beside(surface.triangles.rows());
  for (std::size_t t = 0; t < beside.size(); ++t) {
    for (const std::int32_t v : surface.triangles.row(t))
      for (const std::int32_t other : around[v])
        if (other != static_cast<std::int32_t>(t)) beside[t].push_back(other);
    sort_unique(beside[t]);
  }
  return beside;
}

struct Facets {
  Points centre, normal;  // normals unit
  Eigen::VectorXd area;
};

Facets facets_of(const Surface& surface) {
  const Eigen::Index count = surface.triangles.rows();
  Facets out{Points(count, 3), Points(count, 3), Eigen::VectorXd(count)};
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    const Vec3 across = (b - a).cross(c - a);
    out.centre.row(t) = (a + b + c) / 3;
    out.area[t] = across.norm() / 2;
    out.normal.row(t) = across.normalized();
  }
  return out;
}

// One round of the filter on the normals: the mean over neighbours by area, distance and likeness.
void smooth_normals(const Facets& facets, const Around& beside, double reach_m, Points& normal) {
  const Points before = normal;
  for (Eigen::Index t = 0; t < normal.rows(); ++t) {
    Vec3 sum = facets.area[t] * before.row(t);
    for (const std::int32_t other : beside[t]) {
      const double apart = (facets.centre.row(t) - facets.centre.row(other)).squaredNorm(),
                   unlike = (before.row(t) - before.row(other)).squaredNorm();
      sum += facets.area[other] *
             std::exp(-apart / (2 * reach_m * reach_m) - unlike / (2 * kAlike * kAlike)) *
             before.row(other).transpose();
    }
    normal.row(t) = sum.normalized();
  }
}

// Vertices where the planes of their triangles, turned to these normals, meet best.
Points follow(const Surface& surface, const Around& around, const Points& normal) {
  Surface moved = surface;
  // Vertices follow the normals in twenty steps; 10 leave a tenth more.
  for (int step = 0; step < 20; ++step) {
    const Points centre = facets_of(moved).centre;
    for (std::size_t v = 0; v < around.size(); ++v) {
      if (around[v].empty()) continue;
      const auto row = static_cast<Eigen::Index>(v);
      Vec3 move = Vec3::Zero();
      for (const std::int32_t t : around[v])
        move += normal.row(t).dot(centre.row(t) - moved.vertices.row(row)) * normal.row(t);
      moved.vertices.row(row) += move / static_cast<double>(around[v].size());
    }
  }
  return moved.vertices;
}

// Vertices of creases: edges that turn by more than kCreaseDeg between triangles each of which goes
// on smoothly over another of its edges. Noise turns edges as sharply, and goes on nowhere.
std::vector<char> on_creases(const Surface& surface, const Points& normal) {
  constexpr double kCreaseDeg = 40, kSmoothDeg = 20;
  const auto sides = sorted_sides(surface.triangles);
  const auto turns = [&](auto begin, double deg) {
    return normal.row(begin->face).dot(normal.row((begin + 1)->face)) <
           std::cos(deg * std::numbers::pi / 180);
  };
  std::vector<char> goes_on(surface.triangles.rows(), 0), on_crease(surface.vertices.rows(), 0);
  for_each_edge(sides, [&](auto begin, auto end) {
    if (end - begin == 2 && !turns(begin, kSmoothDeg))
      goes_on[begin->face] = goes_on[(begin + 1)->face] = 1;
  });
  for_each_edge(sides, [&](auto begin, auto end) {
    if (end - begin == 2 && turns(begin, kCreaseDeg) && goes_on[begin->face] &&
        goes_on[(begin + 1)->face])
      on_crease[begin->low] = on_crease[begin->high] = 1;
  });
  return on_crease;
}

}  // namespace

FilteredSurface filter_noise(const Surface& surface, double noise_m) {
  const Around around = cells_around(surface.triangles, surface.vertices.rows()),
               beside = neighbours_of(surface, around);
  const Facets facets = facets_of(surface);
  const Points outward = vertex_normals(surface);
  double reach_m = 0;
  std::size_t pairs = 0;
  for (std::size_t t = 0; t < beside.size(); ++t)
    for (const std::int32_t other : beside[t]) {
      reach_m += (facets.centre.row(t) - facets.centre.row(other)).norm();
      ++pairs;
    }
  reach_m /= static_cast<double>(std::max<std::size_t>(pairs, 1));
  const auto moved_along = [&](const Points& vertices) -> Eigen::VectorXd {
    return (vertices - surface.vertices).cwiseProduct(outward).rowwise().sum();
  };
  FilteredSurface out{.surface = surface};
  Points normal = facets.normal;
  for (int round = 0; round < 20 && out.moved_m < noise_m; ++round) {
    smooth_normals(facets, beside, reach_m, normal);
    const Points next = follow(surface, around, normal);
    const Eigen::VectorXd was = moved_along(out.surface.vertices), is = moved_along(next);
    // |(1 - s) was + s is| = noise_m: the share s of the last round.
    const Eigen::VectorXd step = is - was;
    const double a = step.squaredNorm(), b = was.dot(step),
                 c = was.squaredNorm() - noise_m * noise_m * static_cast<double>(was.size());
    const double share =
        a > 0 ? std::min((-b + std::sqrt(std::max(b * b - a * c, 0.0))) / a, 1.0) : 1;
    out.surface.vertices += share * (next - out.surface.vertices);
    out.moved_m =
        moved_along(out.surface.vertices).norm() / std::sqrt(static_cast<double>(was.size()));
    if (share < 1) break;
  }
  out.max_moved_m = (out.surface.vertices - surface.vertices).rowwise().norm().maxCoeff();
  return out;
}

double roughness_m(const Surface& surface) {
  const Eigen::Index count = surface.vertices.rows();
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  std::vector<Eigen::Triplet<double>> edges;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      edges.emplace_back(t[k], t[(k + 1) % 3], 1);
      edges.emplace_back(t[(k + 1) % 3], t[k], 1);
    }
  Matrix laplacian(count, count);
  laplacian.setFromTriplets(edges.begin(), edges.end());
  for (Eigen::Index v = 0; v < count; ++v) {
    const auto degree = static_cast<double>(laplacian.row(v).nonZeros());
    for (Matrix::InnerIterator it(laplacian, v); it; ++it) it.valueRef() = -1 / degree;
  }
  Matrix identity(count, count);
  identity.setIdentity();
  laplacian += identity;
  const Matrix twice = laplacian * laplacian;
  const Points residual = twice * surface.vertices, normals = vertex_normals(surface);
  std::vector<char> is_apart = on_creases(surface, facets_of(surface).normal);
  const std::vector<char> on_crease = is_apart;
  for (const auto& t : surface.triangles.rowwise())
    for (const std::int32_t v : t)
      if (on_crease[v])
        for (const std::int32_t beside : t) is_apart[beside] = 1;
  std::vector<double> size;
  for (Eigen::Index v = 0; v < count; ++v)
    if (const double gain = twice.row(v).norm(); gain > 0 && !is_apart[v])
      size.push_back(std::abs(residual.row(v).dot(normals.row(v))) / gain);
  // The standard deviation is 1.4826 times the median of absolute values.
  return size.empty() ? 0 : 1.4826 * median(size);
}

}  // namespace palpate
