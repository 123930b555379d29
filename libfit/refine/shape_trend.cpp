#include "libfit/refine/shape_trend.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace palpate {
namespace {

constexpr double kRidge = 1;         // in rows of a mean size
constexpr double kCellShare = 0.15;  // of the patch's radius: that of a cell

Eigen::VectorXd vertex_areas(const Surface& surface) {
  Eigen::VectorXd area = Eigen::VectorXd::Zero(surface.vertices.rows());
  for (const auto& t : surface.triangles.rowwise()) {
    const Vec3 a = surface.vertices.row(t[0]), b = surface.vertices.row(t[1]),
               c = surface.vertices.row(t[2]);
    const double third = (b - a).cross(c - a).norm() / 6;
    for (int k = 0; k < 3; ++k) area[t[k]] += third;
  }
  return area;
}

// Vertices joined to cells, so that a patch has some fifty of them however fine the surface is.
struct Cells {
  std::vector<std::int32_t> of_vertex;
  std::vector<double> area;
  std::vector<Vec3> position, outward;  // area-weighted means
  std::vector<std::set<std::int32_t>> neighbours;
};

Cells cells_of(const Surface& fine, const Points& outward, double radius_m) {
  const auto vertices = static_cast<std::int32_t>(fine.vertices.rows());
  const Neighbours neighbours(fine.triangles, vertices);
  const Eigen::VectorXd area = vertex_areas(fine);
  Cells out;
  out.of_vertex.assign(static_cast<std::size_t>(vertices), -1);
  std::vector<std::int32_t> members;
  for (std::int32_t middle = 0; middle < vertices; ++middle) {
    if (out.of_vertex[static_cast<std::size_t>(middle)] >= 0) continue;
    const auto cell = static_cast<std::int32_t>(out.area.size());
    members.assign(1, middle);
    out.of_vertex[static_cast<std::size_t>(middle)] = cell;
    Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {  // grows
      const std::int32_t v = members[i];
      position += area[v] * fine.vertices.row(v).transpose();
      normal += area[v] * outward.row(v).transpose();
      sum += area[v];
      for (const std::int32_t n : neighbours.of(v))
        if (out.of_vertex[static_cast<std::size_t>(n)] < 0 &&
            (fine.vertices.row(n) - fine.vertices.row(middle)).norm() < radius_m) {
          out.of_vertex[static_cast<std::size_t>(n)] = cell;
          members.push_back(n);
        }
    }
    out.area.push_back(sum);
    out.position.push_back(sum > 0 ? Vec3(position / sum) : Vec3(fine.vertices.row(middle)));
    out.outward.push_back(normal.stableNormalized());
  }
  out.neighbours.resize(out.area.size());
  for (std::int32_t v = 0; v < vertices; ++v)
    for (const std::int32_t n : neighbours.of(v)) {
      const std::int32_t a = out.of_vertex[static_cast<std::size_t>(v)],
                         b = out.of_vertex[static_cast<std::size_t>(n)];
      if (a != b) out.neighbours[static_cast<std::size_t>(a)].insert(b);
    }
  return out;
}

// Half the divergence of the outward normals by least squares over offsets along the surface.
double mean_curvature_1_m(const Cells& cells, const Vec3& at,
                          const std::vector<std::int32_t>& patch) {
  Vec3 mean = Vec3::Zero();
  for (const std::int32_t c : patch)
    mean += cells.area[static_cast<std::size_t>(c)] * cells.outward[static_cast<std::size_t>(c)];
  mean.stableNormalize();
  const Vec3 first = mean.unitOrthogonal(), second = mean.cross(first);
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const std::int32_t c : patch) {
    const auto i = static_cast<std::size_t>(c);
    const Vec3 way = cells.position[i] - at, normal = cells.outward[i];
    const Vec3 row(1, way.dot(first), way.dot(second));
    normal_matrix += cells.area[i] * row * row.transpose();
    right += cells.area[i] * row * Eigen::RowVector2d(normal.dot(first), normal.dot(second));
  }
  const Eigen::Matrix<double, 3, 2> fitted =
      normal_matrix.completeOrthogonalDecomposition().solve(right);
  return 0.5 * (fitted(1, 0) + fitted(2, 1));
}

}  // namespace

ShapeCovariates shape_covariates(const Surface& fine, const Points& outward_normal,
                                 const std::vector<char>& is_wanted,
                                 const std::vector<EdgePathSeeds>& seeds, double radius_m) {
  const Cells cells = cells_of(fine, outward_normal, kCellShare * radius_m);
  std::vector<char> is_needed = is_wanted;
  for (const EdgePathSeeds& of_point : seeds)
    for (const EdgePathSeed& seed : of_point) is_needed[static_cast<std::size_t>(seed.vertex)] = 1;

  ShapeCovariates out;
  out.at_vertex.setZero(fine.vertices.rows(), 4);
  std::vector<std::int32_t> seen_by(cells.area.size(), -1), patch;
  for (std::int32_t v = 0; v < fine.vertices.rows(); ++v) {
    if (is_needed[static_cast<std::size_t>(v)] == 0) continue;
    const Vec3 at = fine.vertices.row(v);
    patch.assign(1, cells.of_vertex[static_cast<std::size_t>(v)]);
    seen_by[static_cast<std::size_t>(patch[0])] = v;
    for (std::size_t i = 0; i < patch.size(); ++i)  // grows
      for (const std::int32_t n : cells.neighbours[static_cast<std::size_t>(patch[i])]) {
        if (std::exchange(seen_by[static_cast<std::size_t>(n)], v) == v) continue;
        if (i == 0 || (cells.position[static_cast<std::size_t>(n)] - at).norm() < radius_m)
          patch.push_back(n);
      }
    out.at_vertex.row(v) << mean_curvature_1_m(cells, at, patch), -outward_normal.row(v);
  }
  // A point lies between the corners of a triangle: nearer ones count more.
  out.at_point.setZero(static_cast<Eigen::Index>(seeds.size()), 4);
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    double sum = 0;
    for (const EdgePathSeed& seed : seeds[p]) {
      const double weight = 1 / (seed.distance_m + 1e-9 * radius_m);
      out.at_point.row(static_cast<Eigen::Index>(p)) += weight * out.at_vertex.row(seed.vertex);
      sum += weight;
    }
    if (sum > 0) out.at_point.row(static_cast<Eigen::Index>(p)) /= sum;
  }
  return out;
}

ShapeRegression regress_on_shape(const ShapeCovariates& covariates,
                                 const Eigen::VectorXd& log_force, const std::vector<char>& is_used,
                                 const std::vector<LeftOutPoint>& rows, std::int32_t without) {
  using Row = Eigen::RowVector4d;
  const auto& x = covariates.at_point;
  std::vector<Eigen::Index> points;
  for (Eigen::Index p = 0; p < log_force.size(); ++p)
    if (is_used[static_cast<std::size_t>(p)] != 0 && p != without) points.push_back(p);
  const auto count = static_cast<double>(points.size());
  ShapeRegression out;
  if (points.empty()) return out;
  out.low = x(points, Eigen::all).colwise().minCoeff();
  out.high = x(points, Eigen::all).colwise().maxCoeff();
  out.mean = x(points, Eigen::all).colwise().sum() / count;
  out.scale =
      ((x(points, Eigen::all).rowwise() - out.mean).colwise().squaredNorm() / count).cwiseSqrt();
  for (double& s : out.scale) s = s > 1e-9 ? 1 / s : 0;
  Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  int used = 0;
  for (const LeftOutPoint& row : rows) {
    if (row.has(without)) continue;
    Row z = x.row(row.point);
    double more = log_force[row.point];
    for (std::size_t k = 0; k < 3; ++k) {
      z -= row.weight[static_cast<Eigen::Index>(k)] * x.row(row.corner[k]);
      more -= row.weight[static_cast<Eigen::Index>(k)] * log_force[row.corner[k]];
    }
    z = z.cwiseProduct(out.scale);
    normal_matrix += z.transpose() * z;
    right += z.transpose() * more;
    ++used;
  }
  if (used == 0) return out;
  const double ridge = kRidge * normal_matrix.trace() / (4 * used);
  if (!(ridge > 0)) return out;
  normal_matrix.diagonal().array() += ridge;
  out.slope = normal_matrix.ldlt().solve(right);
  return out;
}

ShapeTrend trend_over(const ShapeCovariates& covariates, const ShapeRegression& regression) {
  ShapeTrend out;
  const auto evaluate = [&](const auto& rows) {
    Eigen::VectorXd values(rows.rows());
    for (Eigen::Index r = 0; r < rows.rows(); ++r) values[r] = regression.at(rows.row(r));
    return values;
  };
  out.at_point = evaluate(covariates.at_point);
  out.at_vertex = evaluate(covariates.at_vertex);
  return out;
}

}  // namespace palpate
