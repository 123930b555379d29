#include "libfit/refine/slopes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libfit/core/node_forces.hpp"
#include "libfit/refine/side_force.hpp"

namespace palpate {
namespace {

constexpr int kDepths = 4;
constexpr int kShares = 4;         // eighths up to a half
constexpr int kMinPoints = 4;      // of which some always agree by chance
constexpr double kWorthIt = 0.95;  // of the error without slopes

// Control values of d, d^2 and d^3 on a basis, a column each: exact up to its degree, else met at
// its Greville abscissae.
Eigen::Matrix<double, Eigen::Dynamic, 3> powers_on(const CurveBasis& basis) {
  const SplineTables t = tabulate(basis);
  const runtime::SplineView view{t.degree, t.pieces, t.knots.data(), t.weights.data(),
                                 t.integrals.data()};
  const int n = basis.size();
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(n, n);
  Eigen::Matrix<double, Eigen::Dynamic, 3> wanted(n, 3);
  const auto knot = [&](int i) {
    return basis.knots_m[static_cast<std::size_t>(std::clamp(i, 0, basis.pieces()))];
  };
  for (int j = 0; j < n; ++j) {
    double x = 0;
    for (int k = 1; k <= basis.degree; ++k) x += knot(j - basis.degree + k) / basis.degree;
    const auto at = runtime::spline_weights(view, runtime::find_piece(view, x), x);
    for (int k = 0; k <= basis.degree; ++k) value(j, at.first + k) = at.value[k];
    wanted.row(j) << x, x * x, x * x * x;
  }
  return value.partialPivLu().solve(wanted);
}

// Points around a point whose triangles close about it; else none.
std::vector<std::int32_t> ring_about(const Triangles& triangles, std::int32_t point) {
  std::set<std::int32_t> ring;
  int count = 0;
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      if (t[k] == point) ++count, ring.insert({t[(k + 1) % 3], t[(k + 2) % 3]});
  if (count != static_cast<int>(ring.size())) return {};
  return {ring.begin(), ring.end()};
}

struct BlendPoints {
  std::array<std::int32_t, 3> point{};
  Vec3 weight = Vec3::Zero();
  double size = std::numeric_limits<double>::infinity();
};

// Area coordinates of the origin, and the radius of the circle through the corners.
std::optional<BlendPoints> around_origin(const std::array<Eigen::Vector2d, 3>& at) {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  BlendPoints out;
  out.weight = Vec3(cross(at[1], at[2]), cross(at[2], at[0]), cross(at[0], at[1])) / area;
  if (!(out.weight.minCoeff() >= 0)) return std::nullopt;
  out.size = (at[1] - at[0]).norm() * (at[2] - at[1]).norm() * (at[0] - at[2]).norm() /
             (2 * std::abs(area));
  return out;
}

// The triangle of a point's neighbours that would answer for its place without it.
std::optional<BlendPoints> without(const FittedCurves& curves,
                                   const std::vector<std::int32_t>& ring, std::int32_t point) {
  const Vec3 normal = curves.normal.row(point);
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  std::vector<Eigen::Vector2d> flat;
  for (const std::int32_t q : ring) {
    const Vec3 way = (curves.position.row(q) - curves.position.row(point)).transpose();
    flat.emplace_back(way.dot(first), way.dot(second));
  }
  std::optional<BlendPoints> best;
  for (std::size_t a = 0; a < ring.size(); ++a)
    for (std::size_t b = a + 1; b < ring.size(); ++b)
      for (std::size_t c = b + 1; c < ring.size(); ++c) {
        std::optional<BlendPoints> found = around_origin({flat[a], flat[b], flat[c]});
        if (!found || (best && !(found->size < best->size))) continue;
        found->point = {ring[a], ring[b], ring[c]};
        best = found;
      }
  return best;
}

}  // namespace

Controls slopes_of(const FittedCurves& fitted) {
  const CurveSet& curves = fitted.curves;
  if (curves.family != CurveFamily::rings) return Controls(curves.points(), 0);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> power = powers_on(curves.basis[0]);
  Controls slopes(curves.points(), 3 * power.rows());
  for (Eigen::Index p = 0; p < curves.points(); ++p) {
    const NodeShape shape(curves, p, fitted.normal.row(p));
    const Vec3 g2 = shape.across * curves.control[runtime::kSide2].row(p).transpose();
    const Vec3 g3 = shape.across * curves.control[runtime::kSide3].row(p).transpose();
    const Vec3 by_power[] = {2 * g2, 3 * (g3 - shape.curvature * g2), -4 * shape.curvature * g3};
    for (Eigen::Index j = 0; j < power.rows(); ++j) {
      Vec3 slope = Vec3::Zero();
      for (int k = 0; k < 3; ++k) slope += power(j, k) * by_power[k];
      slopes.row(p).segment<3>(3 * j) = slope.transpose();
    }
  }
  return slopes;
}

SlopeShare choose_slope_share(const FittedCurves& curves, const Triangles& triangles,
                              const std::vector<char>& is_usable, const Controls& slopes) {
  SlopeShare out;
  if (slopes.cols() == 0) return out;
  const double range_m = curves.curves.basis[0].knots_m.back();
  CurveSet one(curves.curves.family);
  one.basis = curves.curves.basis;
  std::array<double, kShares + 1> error{};
  for (std::int32_t p = 0; p < curves.curves.points(); ++p) {
    std::vector<std::int32_t> ring = ring_about(triangles, p);
    std::erase_if(ring, [&](auto q) { return is_usable[static_cast<std::size_t>(q)] == 0; });
    if (is_usable[static_cast<std::size_t>(p)] == 0) continue;
    const auto corners = without(curves, ring, p);
    if (!corners) continue;
    ++out.points;
    const Eigen::Index n = curves.curves.control[0].cols();
    // Rows: what is true, what is predicted without slopes, what slopes add.
    one.control[0] = Controls::Zero(3, n);
    one.control[0].row(0) = curves.curves.control[0].row(p);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t l = corners->point[static_cast<std::size_t>(k)];
      const Vec3 way = (curves.position.row(p) - curves.position.row(l)).transpose();
      one.control[0].row(1) += corners->weight[k] * curves.curves.control[0].row(l);
      for (Eigen::Index j = 0; j < n; ++j)
        one.control[0](2, j) +=
            corners->weight[k] * slopes.row(l).segment<3>(3 * j).dot(way.transpose());
    }
    const NodeForces forces(one);
    for (int step = 1; step <= kDepths; ++step) {
      const double depth_m = range_m * step / kDepths;
      const double truth = forces.normal_N(0, depth_m);
      if (!(truth > 0)) continue;
      const double plain = forces.normal_N(1, depth_m) - truth, more = forces.normal_N(2, depth_m);
      for (int share = 0; share <= kShares; ++share)
        error[static_cast<std::size_t>(share)] +=
            std::abs(plain + 0.125 * share * more) / truth / kDepths;
    }
  }
  if (out.points == 0) return out;
  for (double& e : error) e /= out.points;
  const auto best = std::min_element(error.begin(), error.end());
  out.plain_error = out.error = error[0];
  if (out.points < kMinPoints || !(*best < kWorthIt * error[0])) return out;
  out.error = *best;
  out.share = 0.125 * static_cast<double>(best - error.begin());
  return out;
}

void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control) {
  for (Eigen::Index j = 1; j < control.size(); ++j)
    control[j] = std::max(control[j], control[j - 1]);
}

}  // namespace palpate
