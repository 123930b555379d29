#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

constexpr int kTerms = 10;  // 1, x, y, x^2, xy, y^2 and the four cubics
constexpr double kSamplesPerRadius =
    4;                         // twelve or more samples a fit of 10 terms even at a corner
constexpr int kMaxSplit = 32;  // a triangle far larger than the patch is sampled no finer

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
  if (!(radius_m > 0))
    throw Error("normal_gradient", "the radius of the patch is not positive",
                "Give the radius of what touches the surface, in metres.");

  std::vector<Sample> samples;
  for (const std::int32_t f : patch_around(centre, radius_m)) {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int split = std::clamp(
        static_cast<int>(std::ceil(kSamplesPerRadius * longest / radius_m)), 1, kMaxSplit);
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
