#include "libfit/scan/nodes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

namespace palpate::scan {
namespace {

constexpr int kMargin = 2;  // squares around the points: one with curves, one for B-splines

// Cubic B-splines alive on an interval, and their slopes over its length, at a share t of it.
std::array<double, 4> splines(double t) {
  const double r = 1 - t;
  return {r * r * r / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
}
std::array<double, 4> spline_slopes(double t) {
  const double r = 1 - t;
  return {-r * r / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
}

}  // namespace

Nodes::Nodes(const Points& points, const Vec3& inward, double spacing_m, double curvature_1_m)
    : spacing_m_(spacing_m),
      radius_m_(1 / std::max(curvature_1_m, 1e-3 / extent_m(points).norm())) {
  // The first axis is the one along which the points extend most.
  axis_[2] = inward.normalized();
  const Points flat = (points.rowwise() - points.colwise().mean()) *
                      (Mat3::Identity() - axis_[2] * axis_[2].transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> spread(Mat3(flat.transpose() * flat));
  axis_[0] = spread.eigenvectors().col(2);
  axis_[1] = axis_[2].cross(axis_[0]);
  center_ = points.colwise().mean().transpose() + radius_m_ * inward;
  Points at(points.rows(), 3);
  for (Eigen::Index i = 0; i < at.rows(); ++i) at.row(i) = coordinates(points.row(i));
  const Vec3 low = at.colwise().minCoeff(), high = at.colwise().maxCoeff();
  for (int k = 0; k < 2; ++k) origin_[k] = low[k] - kMargin * spacing_m;
  columns_ = static_cast<int>((high[0] - low[0]) / spacing_m) + 2 * kMargin + 2;
  rows_ = static_cast<int>((high[1] - low[1]) / spacing_m) + 2 * kMargin + 2;
  std::vector<char> is_used(columns_ * rows_, 0);
  for (Eigen::Index p = 0; p < points.rows(); ++p) {
    const Vec3 x = coordinates(points.row(p)) / spacing_m;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j) is_used[(int(x[0]) + i) * rows_ + int(x[1]) + j] = 1;
  }
  cell_at_.assign(is_used.size(), -1);
  for (int i = 1; i + 2 < columns_; ++i)
    for (int j = 1; j + 2 < rows_; ++j) {
      if (!is_used[i * rows_ + j]) continue;
      cell_at_[i * rows_ + j] = cells();
      index_.push_back({i, j});
      Cell& cell = cell_.emplace_back();
      for (int k = 0; k < 4; ++k) cell.corner[k] = (i + k / 2) * rows_ + j + k % 2;
      for (int k = 0; k < kHeights; ++k) cell.height[k] = (i - 1 + k / 4) * rows_ + j - 1 + k % 4;
    }
}

std::vector<std::array<int, 2>> Nodes::pairs() const {
  std::vector<std::array<int, 2>> out;
  for (int i = 0; i < columns_; ++i)
    for (int j = 0; j < rows_; ++j) {
      if (i + 1 < columns_) out.push_back({i * rows_ + j, (i + 1) * rows_ + j});
      if (j + 1 < rows_) out.push_back({i * rows_ + j, i * rows_ + j + 1});
    }
  return out;
}

std::vector<std::array<int, 3>> Nodes::triples() const {
  std::vector<std::array<int, 3>> out;
  for (int i = 0; i < columns_; ++i)
    for (int j = 0; j < rows_; ++j) {
      const int at = i * rows_ + j;
      if (i + 2 < columns_) out.push_back({at, at + rows_, at + 2 * rows_});
      if (j + 2 < rows_) out.push_back({at, at + 1, at + 2});
    }
  return out;
}

Vec3 Nodes::coordinates(const Vec3& point) const {
  const Vec3 offset = point - center_;
  const double x = axis_[0].dot(offset), y = axis_[1].dot(offset), side = std::hypot(x, y),
               angle = std::atan2(side, -axis_[2].dot(offset)),
               scale = radius_m_ * (side > 0 ? angle / side : 1 / offset.norm());
  return {scale * x - origin_[0], scale * y - origin_[1], radius_m_ - offset.norm()};
}

Vec3 Nodes::position(double first, double second, double height_m) const {
  const double x = first + origin_[0], y = second + origin_[1], side = std::hypot(x, y),
               angle = side / radius_m_, scale = side > 0 ? std::sin(angle) / side : 0;
  return center_ + (radius_m_ - height_m) *
                       (scale * (x * axis_[0] + y * axis_[1]) - std::cos(angle) * axis_[2]);
}

Mat3 Nodes::gradients(const Vec3& point) const {
  const Vec3 outward = (point - center_).normalized(), pole = -axis_[2];
  const Vec3 side = outward - outward.dot(pole) * pole;
  const double sine = side.norm(), angle = std::atan2(sine, outward.dot(pole)),
               wider = sine > 0 ? angle / sine : 1;
  const Vec3 away = sine > 0 ? Vec3(side / sine) : axis_[0], around = pole.cross(away),
             along = around.cross(outward);
  Mat3 out;
  for (int k = 0; k < 2; ++k)
    out.col(k) = radius_m_ / (point - center_).norm() *
                 (away.dot(axis_[k]) * along + wider * around.dot(axis_[k]) * around);
  out.col(2) = -outward;
  return out;
}

Nodes::CellPlace Nodes::at(double first, double second, int cell) const {
  CellPlace out;
  const double x = first / spacing_m_, y = second / spacing_m_;
  if (cell < 0) {
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    if (i < 0 || j < 0 || i >= columns_ || j >= rows_) return out;
    cell = cell_at_[i * rows_ + j];
  }
  if (cell < 0) return out;
  out.cell = cell;
  const double s = std::clamp(x - index_[cell][0], 0.0, 1.0),
               t = std::clamp(y - index_[cell][1], 0.0, 1.0);
  out.corner = {(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t};
  const auto u = splines(s), v = splines(t), du = spline_slopes(s), dv = spline_slopes(t);
  for (int k = 0; k < kHeights; ++k) {
    out.height[k] = u[k / 4] * v[k % 4];
    out.slope1[k] = du[k / 4] * v[k % 4] / spacing_m_;
    out.slope2[k] = u[k / 4] * dv[k % 4] / spacing_m_;
  }
  return out;
}

Nodes::Foot Nodes::foot(const Vec3& point, const Eigen::VectorXd& height) const {
  const Vec3 x = coordinates(point);
  Foot out;
  double first = x[0], second = x[1];
  for (int step = 0; step < 4; ++step) {
    const CellPlace place = at(first, second);
    if (place.cell < 0) break;
    double h = 0, slope1 = 0, slope2 = 0;
    for (int k = 0; k < kHeights; ++k) {
      const double node = height[cell_[place.cell].height[k]];
      h += place.height[k] * node;
      slope1 += place.slope1[k] * node;
      slope2 += place.slope2[k] * node;
    }
    out.place = place;
    out.position = position(first, second, h);
    const Mat3 gradient = gradients(out.position);
    out.normal =
        (gradient.col(2) - slope1 * gradient.col(0) - slope2 * gradient.col(1)).normalized();
    out.depth_m = (point - out.position).dot(out.normal);
    const Vec3 next = coordinates(point - std::max(out.depth_m, 0.0) * out.normal);
    first = next[0], second = next[1];
  }
  return out;
}

Nodes::NodeMesh Nodes::mesh(const Eigen::VectorXd& height, int parts) const {
  NodeMesh out;
  std::map<std::array<int, 2>, int> number;
  std::vector<Vec3> position;
  std::vector<std::array<int, 3>> triangles;
  for (int c = 0; c < cells(); ++c) {
    const auto vertex = [&](int i, int j) {
      const auto [at, is_new] = number.emplace(
          std::array{index_[c][0] * parts + i, index_[c][1] * parts + j}, std::ssize(position));
      if (!is_new) return at->second;
      const double first = (index_[c][0] + double(i) / parts) * spacing_m_,
                   second = (index_[c][1] + double(j) / parts) * spacing_m_;
      const CellPlace& place = out.vertex.emplace_back(this->at(first, second, c));
      double h = 0;
      for (int k = 0; k < kHeights; ++k) h += place.height[k] * height[cell_[c].height[k]];
      position.push_back(this->position(first, second, h));
      return at->second;
    };
    for (int i = 0; i < parts; ++i)
      for (int j = 0; j < parts; ++j) {
        // Diagonals alternate.
        const int a = vertex(i, j), b = vertex(i + 1, j), d = vertex(i, j + 1),
                  e = vertex(i + 1, j + 1);
        const bool is_turned = (index_[c][0] * parts + i + index_[c][1] * parts + j) % 2 != 0;
        triangles.push_back(is_turned ? std::array{a, d, b} : std::array{a, d, e});
        triangles.push_back(is_turned ? std::array{b, d, e} : std::array{a, e, b});
        out.triangle_cell.insert(out.triangle_cell.end(), 2, c);
      }
  }
  out.surface.vertices.resize(std::ssize(position), 3);
  for (std::size_t v = 0; v < position.size(); ++v) out.surface.vertices.row(v) = position[v];
  out.surface.triangles.resize(std::ssize(triangles), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    out.surface.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
  return out;
}

}  // namespace palpate::scan
