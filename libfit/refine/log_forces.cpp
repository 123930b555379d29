#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/refine/interpolation.hpp"

namespace palpate {
namespace {

constexpr int kCircles = 12;
constexpr int kCells = 12;  // of the grid of heights, from the middle to its side
constexpr double kSlack = 1e-9;
constexpr double kNone = -std::numeric_limits<double>::infinity();

using CircleNumbers = std::array<double, kCircles + 1>;

CircleNumbers sum_of(CircleNumbers a, const CircleNumbers& b) {
  for (int i = 0; i <= kCircles; ++i) a[i] += b[i];
  return a;
}

// Radii of circles, and what of the tool stands at them: the profile of springs (M80).
struct Springs {
  CircleNumbers radius_m{}, depth_m{};
  // of the height of circle j in the height of spring i
  std::array<CircleNumbers, kCircles + 1> share{};
};

Springs springs_of(const Indenter& tool, double range_m) {
  Springs out;
  // Contacts in a hollow are wider than on an even body.
  const double widest_m =
      std::min(0.97 * runtime::widest_m(tool), 1.3 * runtime::contact_radius_at(tool, range_m));
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
    const int angles = r_m > 0 ? 16 : 1;
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

  // Adds the heights of a triangle; false where it does not face the tool or reach under it.
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
double spring_sum(const Springs& springs, const CircleNumbers& gap_m, double depth_m) {
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

// k of a place by the shape of its surface (M83a): how much more than on an even body the force of
// the gap grows with the radius of the ball, to the power 1/2. Balls of half and of one and a half
// times the radius on two livers and a cylinder: medians 0.9 to 4.4 %, p95 2 to 12; to the power
// 1/4 medians 1 to 4 and p95 2 to 15, to the power 1 0.6 to 8 and 2 to 14 %.
class ShapeEffect {
 public:
  ShapeEffect(const Springs& own, double ball_m, double range_m) : own_(own), range_m_(range_m) {
    // Balls of half and of one and a half times the radius have most tools between them.
    for (const double ratio : {0.5, 1.5}) {
      OtherBall& other = others_.emplace_back();
      other.log_ratio = std::log(ratio);
      const Indenter ball = runtime::ball_indenter(ratio * ball_m);
      for (int i = 0; i <= kCircles; ++i)
        other.depth_m[i] = runtime::depth_at(ball, own_.radius_m[i]);
    }
  }

  // rise_m: of the gap over an even surface's, circle by circle.
  double of(const CircleNumbers& rise_m) const {
    double sum = 0, weight = 0;
    for (int step = 1; step <= kComparedDepths; ++step) {
      const double depth_m = range_m_ * step / kComparedDepths,
                   own = over_even(own_.depth_m, rise_m, depth_m);
      for (const OtherBall& other : others_) {
        const double more = std::sqrt(over_even(other.depth_m, rise_m, depth_m) / own) - 1;
        sum += other.log_ratio * more;
        weight += other.log_ratio * other.log_ratio;
      }
    }
    return std::clamp(sum / weight, -runtime::kMostRadiusEffect, runtime::kMostRadiusEffect);
  }

 private:
  struct OtherBall {
    double log_ratio = 0;
    CircleNumbers depth_m{};
  };
  double over_even(const CircleNumbers& even_m, const CircleNumbers& rise_m, double depth_m) const {
    return spring_sum(own_, sum_of(even_m, rise_m), depth_m) / spring_sum(own_, even_m, depth_m);
  }
  const Springs& own_;
  double range_m_;
  std::vector<OtherBall> others_;
};

// In spacings of the points, and nuggets in variances of the field. None is chosen by hand: each
// counts as much as the points make it likely.
constexpr double kRanges[] = {2, 4, 8, 16}, kTurns[] = {1, 4}, kNuggets[] = {1e-3, 1e-2, 1e-1, 1};

double spacing_of(const Points& position) {
  std::vector<double> nearest;
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    Eigen::VectorXd away = (position.rowwise() - position.row(i)).rowwise().norm();
    away[i] = std::numeric_limits<double>::infinity();
    nearest.push_back(away.minCoeff());
  }
  return upper_median(std::move(nearest));
}

}  // namespace

GapForces gap_forces(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                     const std::vector<char>& is_wanted, const std::vector<EdgePathSeeds>& seeds,
                     const Indenter& tool) {
  const double range_m = curves.curves.basis[0].knots_m.back();
  const Springs springs = springs_of(tool, range_m);
  HeightGrid grid(fine, springs.radius_m.back());
  const auto rise_at = [&](const Vec3& place, const Vec3& outward,
                           const std::vector<std::int32_t>& from) {
    grid.look_at(place, outward, from);
    CircleNumbers height{}, rise{};
    for (int i = 0; i <= kCircles; ++i)
      height[i] = grid.mean_m(springs.radius_m[i], i > 0 ? height[i - 1] : 0);
    for (int i = 0; i <= kCircles; ++i) {
      rise[i] = height[0];  // deflection counts from the place itself
      for (int j = 0; j <= i; ++j) rise[i] -= springs.share[i][j] * height[j];
    }
    return rise;
  };
  const auto log_force = [&](const CircleNumbers& rise) {
    const CircleNumbers gap = sum_of(springs.depth_m, rise);
    Eigen::RowVector<double, kComparedDepths> out;
    for (int k = 0; k < kComparedDepths; ++k)
      out[k] = std::log(spring_sum(springs, gap, range_m * (k + 1) / kComparedDepths));
    return out;
  };

  GapForces out;
  out.force.at_point.setZero(seeds.size(), kComparedDepths);
  out.force.at_vertex.setZero(fine.vertices.rows(), kComparedDepths);
  out.radius_effect.setZero(fine.vertices.rows());
  std::vector<std::int32_t> from;
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    from.clear();
    for (const EdgePathSeed& seed : seeds[p]) from.push_back(seed.vertex);
    if (!from.empty())
      out.force.at_point.row(p) =
          log_force(rise_at(curves.position.row(p), -curves.normal.row(p), from));
  }
  std::optional<ShapeEffect> effect;
  if (tool.points == 0) effect.emplace(springs, tool.round_end_m, range_m);
  for (std::int32_t v = 0; v < fine.vertices.rows(); ++v) {
    if (is_wanted[v] == 0) continue;
    const CircleNumbers rise = rise_at(fine.vertices.row(v), outward_normal.row(v), {v});
    out.force.at_vertex.row(v) = log_force(rise);
    if (effect) out.radius_effect[v] = effect->of(rise);
  }
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

// Matern's with smoothness 3/2 (Stein 1999).
Eigen::MatrixXd Kriging::between(const Covariance& covariance, const Points& a,
                                 const Points& a_normal, const Points& b, const Points& b_normal) {
  const double turn2 = covariance.turn_m * covariance.turn_m;
  Eigen::MatrixXd out(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < b.rows(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      double away2 = (a.row(i) - b.row(j)).squaredNorm();
      if (turn2 > 0) away2 += turn2 * (a_normal.row(i) - b_normal.row(j)).squaredNorm();
      const double r = std::sqrt(3 * away2) / covariance.range_m;
      out(i, j) = (1 + r) * std::exp(-r);
    }
  return out;
}

struct Kriging::FittedCovariance {
  double log_likelihood = -std::numeric_limits<double>::infinity();
  Eigen::RowVectorXd mean;
  Eigen::MatrixXd weight, left_out;
};

Kriging::FittedCovariance Kriging::fitted(const Covariance& of, const Points& position,
                                          const Points& normal, const Eigen::MatrixXd& value) {
  const Eigen::Index n = value.rows();
  Eigen::MatrixXd covariance = between(of, position, normal, position, normal);
  covariance.diagonal().array() += of.nugget;
  const auto [inverse, log_determinant, is_positive] = cholesky_inverse(covariance);
  if (!is_positive) return {};
  const Eigen::VectorXd of_ones = inverse.rowwise().sum();
  const double total = of_ones.sum();
  FittedCovariance out;
  out.mean = of_ones.transpose() * value / total;
  const Eigen::MatrixXd residual = value.rowwise() - out.mean;
  out.weight = inverse * residual;
  const Eigen::ArrayXd squares = residual.cwiseProduct(out.weight)
                                     .colwise()
                                     .sum()
                                     .transpose()
                                     .array()
                                     .max(std::numeric_limits<double>::min());
  out.log_likelihood =
      -0.5 * (double(n - 1) * squares.log().mean() + log_determinant + std::log(total));
  const Eigen::VectorXd precision = inverse.diagonal() - of_ones.cwiseProduct(of_ones) / total;
  out.left_out = value - precision.cwiseInverse().asDiagonal() * out.weight;
  return out;
}

Kriging::Kriging(const Points& position, const Points& normal, const Eigen::MatrixXd& value)
    : position_(position),
      normal_(normal),
      left_out_(Eigen::MatrixXd::Zero(value.rows(), value.cols())) {
  const double spacing_m = spacing_of(position);
  std::vector<Eigen::Index> some;
  for (Eigen::Index p = 0; p < value.rows(); p += 1 + (value.rows() - 1) / 300)  // judges enough
    some.push_back(p);
  const bool is_all = std::ssize(some) == value.rows();
  const bool has_normals = normal.rows() > 0;
  const Points some_position = position(some, Eigen::all),
               some_normal = has_normals ? Points(normal(some, Eigen::all)) : normal;
  std::vector<Covariance> covariances;
  std::vector<FittedCovariance> tried;
  double likeliest = -std::numeric_limits<double>::infinity(), sum = 0;
  for (const double turn : kTurns)
    for (const double range : kRanges)
      for (const double nugget : kNuggets) {
        if (!has_normals && turn != kTurns[0]) continue;
        covariances.push_back({range * spacing_m, has_normals ? turn * spacing_m : 0, nugget});
        tried.push_back(
            fitted(covariances.back(), some_position, some_normal, value(some, Eigen::all)));
        likeliest = std::max(likeliest, tried.back().log_likelihood);
      }
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const double share = std::exp(tried[k].log_likelihood - likeliest);
    if (!(share > 1e-3)) continue;  // of the likeliest
    FittedCovariance all =
        is_all ? std::move(tried[k]) : fitted(covariances[k], position, normal, value);
    left_out_ += share * all.left_out;
    sum += share;
    kept_.push_back({covariances[k], share, all.mean, std::move(all.weight)});
  }
  left_out_ /= sum;
  for (KeptCovariance& k : kept_) k.share /= sum;
}

Eigen::MatrixXd Kriging::at(const Points& position, const Points& normal) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(position.rows(), left_out_.cols());
  constexpr Eigen::Index kAtOnce = 256;
  for (Eigen::Index first = 0; first < out.rows(); first += kAtOnce) {
    const Eigen::Index count = std::min(kAtOnce, out.rows() - first);
    for (const KeptCovariance& k : kept_) {
      const Eigen::MatrixXd residual =
          between(k.covariance, position.middleRows(first, count),
                  normal_.rows() > 0 ? Points(normal.middleRows(first, count)) : normal_, position_,
                  normal_) *
          k.weight;
      out.middleRows(first, count) += k.share * (residual.rowwise() + k.mean);
    }
  }
  return out;
}

}  // namespace palpate
