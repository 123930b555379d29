#include "libfit/refine/gap_force.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace palpate {
namespace {

constexpr int kCircles = 12, kAngles = 16;
constexpr int kCells = 12;              // of the grid of heights, from the middle to its side
constexpr double kWiderThanEven = 1.3;  // contacts in a hollow are wider than on an even body
constexpr double kSlack = 1e-9;
constexpr double kNone = -std::numeric_limits<double>::infinity();

// Radii of circles, and what of the tool stands at them: the profile of springs (M80).
struct Springs {
  std::array<double, kCircles + 1> radius_m{}, depth_m{};
  // of the height of circle j in the height of spring i
  std::array<std::array<double, kCircles + 1>, kCircles + 1> share{};
};

Springs springs_of(const Indenter& tool, double range_m) {
  Springs out;
  const double widest_m = std::min(0.97 * runtime::widest_m(tool),
                                   kWiderThanEven * runtime::contact_radius_at(tool, range_m));
  for (int i = 0; i <= kCircles; ++i) {
    out.radius_m[i] = widest_m * i / kCircles;
    out.depth_m[i] = runtime::depth_at(tool, out.radius_m[i]);
  }
  // (M12d): h(0) + x int_0^x h'(r) / sqrt(x^2 - r^2) dr of heights that are linear between circles
  out.share[0][0] = 1;
  for (int i = 1; i <= kCircles; ++i) {
    out.share[i][0] = 1;
    for (int j = 0; j < i; ++j) {
      const double angle = std::asin((j + 1.0) / i) - std::asin(double(j) / i);
      out.share[i][j] -= i * angle;
      out.share[i][j + 1] += i * angle;
    }
  }
  return out;
}

// Heights of the surface along the normal over a square grid around a place.
class HeightGrid {
 public:
  HeightGrid(const Surface& fine, double radius_m)
      : fine_(fine),
        seen_(fine.vertices.rows(), -1),
        triangle_seen_(fine.triangles.rows(), -1),
        triangles_(fine.triangles, fine.vertices.rows()),
        radius_m_(radius_m) {
    const Neighbours neighbours(fine.triangles, fine.vertices.rows());
    for (std::int32_t v = 0; v < fine.vertices.rows(); ++v)
      is_border_.push_back(neighbours.of(v).size() > triangles_.of(v).size());
  }

  // From the vertices `from` on, what hangs together and faces the tool.
  void look_at(const Vec3& place, const Vec3& outward, const std::vector<std::int32_t>& from) {
    const Vec3 first = outward.unitOrthogonal(), second = outward.cross(first);
    axes_ << first.transpose(), second.transpose(), outward.transpose();
    place_ = place;
    height_.fill(kNone);
    has_border_ = false;
    ++turn_;
    patch_.clear();
    for (const std::int32_t v : from) visit(v);
    for (std::size_t i = 0; i < patch_.size(); ++i) {  // grows
      const std::int32_t v = patch_[i];
      has_border_ |= is_border_[v] != 0;
      for (const std::int32_t f : triangles_.of(v)) {
        if (std::exchange(triangle_seen_[f], turn_) == turn_) continue;
        if (!add(f)) continue;
        for (int corner = 0; corner < 3; ++corner) visit(fine_.triangles(f, corner));
      }
    }
  }

  // Mean over a circle. Nothing on it: past the body's side it is deep; past the border of an open
  // surface it is not known, and `otherwise`.
  double mean_m(double r_m, double otherwise) const {
    double sum = 0;
    int count = 0;
    const int angles = r_m > 0 ? kAngles : 1;
    for (int k = 0; k < angles; ++k) {
      const double angle = 2 * std::numbers::pi * k / angles,
                   height = at(r_m * std::cos(angle), r_m * std::sin(angle));
      if (height == kNone && has_border_) continue;
      sum += std::max(height, -radius_m_);
      ++count;
    }
    return count > 0 ? sum / count : otherwise;
  }

 private:
  static constexpr int kSide = 2 * kCells + 1;

  void visit(std::int32_t v) {
    if (std::exchange(seen_[v], turn_) != turn_) patch_.push_back(v);
  }
  double node(int i) const { return radius_m_ * (i - kCells) / kCells; }
  int first_node(double x) const {
    return std::clamp(static_cast<int>(std::ceil(x / radius_m_ * kCells - 1e-9)) + kCells, 0,
                      kSide);
  }

  // Whether it faces the tool and reaches under it.
  bool add(std::int32_t f) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k)
      corner[k] = axes_ * (fine_.vertices.row(fine_.triangles(f, k)).transpose() - place_);
    const Eigen::Vector2d a = corner[0].head<2>(), u = corner[1].head<2>() - a,
                          w = corner[2].head<2>() - a;
    const double area = u.x() * w.y() - u.y() * w.x();
    if (!(area > 0)) return false;
    Eigen::Vector2d low = a, high = a;
    for (int k = 1; k < 3; ++k) {
      low = low.cwiseMin(corner[k].head<2>());
      high = high.cwiseMax(corner[k].head<2>());
    }
    if (low.maxCoeff() > radius_m_ || high.minCoeff() < -radius_m_) return false;
    for (int i = first_node(low.x()); i < kSide && node(i) <= high.x() + kSlack * radius_m_; ++i)
      for (int j = first_node(low.y()); j < kSide && node(j) <= high.y() + kSlack * radius_m_;
           ++j) {
        const Eigen::Vector2d q = Eigen::Vector2d(node(i), node(j)) - a;
        const double s = (q.x() * w.y() - q.y() * w.x()) / area,
                     t = (u.x() * q.y() - u.y() * q.x()) / area;
        if (s < -kSlack || t < -kSlack || s + t > 1 + kSlack) continue;
        double& height = height_[i * kSide + j];
        height = std::max(height, corner[0].z() + s * (corner[1].z() - corner[0].z()) +
                                      t * (corner[2].z() - corner[0].z()));
      }
    return true;
  }

  // From the nodes around that have a height.
  double at(double x, double y) const {
    const double s = x / radius_m_ * kCells + kCells, t = y / radius_m_ * kCells + kCells;
    const int i = std::min(static_cast<int>(s), kSide - 2),
              j = std::min(static_cast<int>(t), kSide - 2);
    const auto height = [&](int k, int l) { return std::min(height_[k * kSide + l], radius_m_); };
    const double a = s - i, b = t - j;
    double sum = 0, weight = 0;
    for (const auto& [w, h] :
         {std::pair((1 - a) * (1 - b), height(i, j)), std::pair((1 - a) * b, height(i, j + 1)),
          std::pair(a * (1 - b), height(i + 1, j)), std::pair(a * b, height(i + 1, j + 1))})
      if (h != kNone) sum += w * h, weight += w;
    return weight > kSlack ? sum / weight : kNone;
  }

  const Surface& fine_;
  std::vector<std::int32_t> seen_, triangle_seen_, patch_;
  TrianglesAt triangles_;
  std::vector<char> is_border_;
  bool has_border_ = false;
  double radius_m_;
  std::int32_t turn_ = 0;
  Eigen::Matrix3d axes_;
  Vec3 place_;
  std::array<double, kSide * kSide> height_{};
};

// (M12d), 2 int_0^a max(0, d - g(x)) dx: of springs between which g is linear.
double spring_sum(const Springs& springs, const std::array<double, kCircles + 1>& gap_m,
                  double depth_m) {
  double sum = 0;
  for (int i = 0; i < kCircles; ++i) {
    const double from = depth_m - gap_m[i], to = depth_m - gap_m[i + 1],
                 width = springs.radius_m[i + 1] - springs.radius_m[i];
    const double low = std::min(from, to), high = std::max(from, to);
    if (high <= 0) continue;
    sum += low >= 0 ? width * (from + to) : width * high * high / (high - low);
  }
  return sum;
}

}  // namespace

LogForces gap_forces(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                     const std::vector<char>& is_wanted, const std::vector<EdgePathSeeds>& seeds,
                     const Indenter& tool) {
  const double range_m = curves.curves.basis[0].knots_m.back();
  const Springs springs = springs_of(tool, range_m);
  HeightGrid grid(fine, springs.radius_m.back());
  const auto force = [&](const Vec3& place, const Vec3& outward,
                         const std::vector<std::int32_t>& from) {
    grid.look_at(place, outward, from);
    std::array<double, kCircles + 1> height{}, gap{};
    for (int i = 0; i <= kCircles; ++i)
      height[i] = grid.mean_m(springs.radius_m[i], i > 0 ? height[i - 1] : 0);
    for (int i = 0; i <= kCircles; ++i) {
      gap[i] = springs.depth_m[i] + height[0];  // deflection counts from the place itself
      for (int j = 0; j <= i; ++j) gap[i] -= springs.share[i][j] * height[j];
    }
    Eigen::RowVector<double, kComparedDepths> out;
    for (int k = 0; k < kComparedDepths; ++k)
      out[k] = std::log(spring_sum(springs, gap, range_m * (k + 1) / kComparedDepths));
    return out;
  };

  LogForces out;
  out.at_point.setZero(seeds.size(), kComparedDepths);
  out.at_vertex.setZero(fine.vertices.rows(), kComparedDepths);
  std::vector<std::int32_t> from;
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    from.clear();
    for (const EdgePathSeed& seed : seeds[p]) from.push_back(seed.vertex);
    if (!from.empty())
      out.at_point.row(p) = force(curves.position.row(p), -curves.normal.row(p), from);
  }
  for (std::int32_t v = 0; v < fine.vertices.rows(); ++v)
    if (is_wanted[v] != 0)
      out.at_vertex.row(v) = force(fine.vertices.row(v), outward_normal.row(v), {v});
  return out;
}

Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& log_force) {
  Eigen::RowVectorXd out(basis.size());
  for (int j = 0; j < basis.size(); ++j) {
    const double step = kComparedDepths * greville_m(basis, j) / basis.knots_m.back() - 1;
    const int i = std::clamp(int(step), 0, kComparedDepths - 2);
    out[j] = log_force[i] + std::clamp(step - i, 0.0, 1.0) * (log_force[i + 1] - log_force[i]);
  }
  return out;
}

}  // namespace palpate
