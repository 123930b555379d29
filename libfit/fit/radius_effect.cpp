#include "libfit/fit/contact_effects.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/fit/point/replay.hpp"
#include "libfit/runtime/asset/with_indenter.hpp"

namespace palpate::fit {
namespace {

using Effect = Eigen::Matrix<double, runtime::kRadiusEffects, 1>;

// Control values of a point as a spot of the engine's templates.
struct PointSpot {
  const double* normal;
  double control(int, int j) const { return normal[j]; }
};

// Stiffening [1] between the ends of which w (M83b) goes from 0 to 1, about 0. Balls of half and of
// one and a half times the radius on seven bodies: with half of it the same to 0.2 %, with twice
// medians up to 0.4 and p95 up to 3 % worse on ridged livers.
constexpr double kStiffening = 0.1;

// The share of stiffness that goes with a contact's radius, by the curve of the asset's own ball
// (M83b): by the power of depth with which its force grows beside Sneddon's of an even half-space
// (1965, doi:10.1016/0020-7225(65)90019-4). A body that stiffens has something stiff below, and
// answers by the width of the contact; one that softens is ridged or strained, and answers by
// depth.
double share_by_width(const FittedCurves& curves, const Bases& bases, Eigen::Index p,
                      double radius_m) {
  const runtime::SplineView& normal = bases.views.view[runtime::kNormal];
  const double* const control = curves.curves.control[runtime::kNormal].row(p).data();
  Eigen::Matrix<double, 4, 2> line;
  Eigen::Vector4d log_modulus;
  for (int i = 0; i < 4; ++i) {
    const double depth_m = normal.knots[normal.pieces] * (i + 1) / 4,
                 a = runtime::contact_radius_at(runtime::ball_indenter(radius_m), depth_m),
                 even = (a * a + radius_m * radius_m) * std::atanh(a / radius_m) - a * radius_m,
                 force_N = runtime::curve_value(normal, control, depth_m);
    if (!(force_N > 0)) return 0;
    line.row(i) << 1, std::log(depth_m);
    log_modulus[i] = std::log(force_N / even);
  }
  const double stiffening = line.householderQr().solve(log_modulus)[1];
  return std::clamp(0.5 + stiffening / kStiffening, 0.0, 1.0);
}

// Bounds k and w of (M83) so that stiffness stays positive.
Effect bounded(const Effect& effect) {
  const double w = std::clamp(effect[1], 0.0, 1.0), most = runtime::kMostRadiusEffect * (1 - w);
  return {std::clamp(effect[0], -most, most), w};
}

// Presses of other indenters at one point, each row with what the law has it be: with k = 0 and w
// by the point's own curve, and by how much k and more of w change it.
struct PressedPoint {
  Eigen::Index point = 0;
  double w = 0;
  std::vector<double> force_N, as_own_ball_N, theory_N, error_N;
  std::vector<Effect> by_radius_N;

  Effect fit() const {
    // k is drawn to 0 by a standard deviation of 0.1, w to its own by 0.5.
    Eigen::Matrix2d normal = Eigen::Vector2d(100, 4).asDiagonal();
    Effect right = Effect::Zero();
    for (std::size_t i = 0; i < force_N.size(); ++i) {
      const double weight = 1 / (error_N[i] * error_N[i]);
      normal += weight * by_radius_N[i] * by_radius_N[i].transpose();
      right += weight * by_radius_N[i] * (force_N[i] - theory_N[i]);
    }
    return normal.ldlt().solve(right);
  }
  void errors(const Effect& more, std::vector<ForceError>& out) const {
    const Effect own(0, w), admissible = bounded(own + more) - own;
    for (std::size_t i = 0; i < force_N.size(); ++i)
      out.push_back(
          {std::abs(theory_N[i] + by_radius_N[i].dot(admissible) - force_N[i]), force_N[i]});
  }
};

// Tables of the indenters on the points' common basis.
class IndenterTables {
 public:
  IndenterTables(const runtime::CurveViews& views, double radius_m, double first_row_m,
                 const std::vector<Indenter>& ends)
      : memory_(ends.size()) {
    asset_.curves = views;
    asset_.probe_radius_m = radius_m;
    asset_.first_row_m = first_row_m;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      memory_[i].resize(runtime::indenter_bytes(asset_) / sizeof(std::uint64_t));
      table_.push_back(runtime::with_indenter(asset_, ends[i], memory_[i].data()));
    }
  }
  const runtime::AssetView& of(std::size_t i) const { return table_[i]; }

 private:
  runtime::AssetView asset_;
  std::vector<std::vector<std::uint64_t>> memory_;
  std::vector<runtime::AssetView> table_;
};

double force_of(const runtime::SplineView& view, const PointSpot& spot, double depth_m) {
  return runtime::piece_of(view, spot, runtime::kNormal, depth_m, false).force(depth_m);
}

std::vector<PressedPoint> pressed_points(const FittedCurves& curves, const Samples& others,
                                         const Bases& bases, const IndenterTables& tables) {
  const double largest_m =
      bases.views.view[runtime::kNormal].knots[bases.views.view[runtime::kNormal].pieces];
  std::map<Eigen::Index, PressedPoint> out;
  for (Eigen::Index row = 0; row < others.rows(); ++row) {
    if (others.status[row] != RowStatus::good) continue;
    const Eigen::Index p = point_at(curves, others.point_position.row(others.point[row]));
    if (p < 0) continue;
    const Vec3 inward = others.point_normal.row(others.point[row]), force = others.force.row(row);
    Vec3 deflection = others.deflection.row(row);
    if (!curves.curves.control[runtime::kSway].row(p).isZero(0))
      deflection -= symmetric_of(curves.curves.control[runtime::kSway].row(p)) * force;
    const double depth_m = deflection.dot(inward), normal_N = force.dot(inward);
    const double aside_m = (deflection - depth_m * inward).norm();
    // On a body that sways presses go aside against the surface around them. With a tenth 8 of 42
    // rows on SOFA's liver are left, with a quarter 34, with half of the depth 41.
    if (!(depth_m > 1e-3 * largest_m) || !(normal_N > 0) || aside_m > 0.25 * depth_m) continue;
    const PointSpot spot{curves.curves.control[runtime::kNormal].row(p).data()};
    const runtime::AssetView& other = tables.of(others.probe_number[row] - 1);
    if (depth_m > other.max_fitted_m) continue;
    PressedPoint& point = out[p];
    point.point = p;
    point.force_N.push_back(normal_N);
    point.as_own_ball_N.push_back(force_of(bases.views.view[runtime::kNormal], spot, depth_m));
    const runtime::SplineView* by_radius = other.curves.indenter->by_radius;
    const double as_deep_N = force_of(other.curves.view[runtime::kNormal], spot, depth_m),
                 wider_N = force_of(by_radius[1], spot, depth_m) - as_deep_N;
    point.w = curves.curves.control[runtime::kRadiusEffect](p, 1);
    point.theory_N.push_back(as_deep_N + point.w * wider_N);
    point.by_radius_N.push_back({force_of(by_radius[0], spot, depth_m), wider_N});
    const double stated = others.force_error[row];
    point.error_N.push_back(std::max(std::isfinite(stated) ? stated : 0, 0.01 * normal_N));
  }
  std::vector<PressedPoint> points;
  for (auto& [p, point] : out) points.push_back(std::move(point));
  return points;
}

// The effect at a place by that of points: weighted by inverse squares of distances, or the mean.
Effect effect_at(const FittedCurves& curves, const std::vector<PressedPoint>& points,
                 const std::vector<Effect>& effect, const Vec3& place, std::size_t without,
                 bool by_distance) {
  Effect sum = Effect::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == without) continue;
    const double squared = (Vec3(curves.position.row(points[i].point)) - place).squaredNorm();
    const double weight = by_distance ? 1 / std::max(squared, 1e-18) : 1;
    sum += weight * effect[i];
    weights += weight;
  }
  return weights > 0 ? Effect(sum / weights) : Effect(Effect::Zero());
}

}  // namespace

void identify_radius_effect(FittedCurves& curves, const Samples& others,
                            const std::vector<Indenter>& ends, RadiusReport* report) {
  const double radius_m = ball_radius_m(curves.probe);
  if (!(radius_m > 0) || curves.curves.family != CurveFamily::rings) return;
  const Bases bases = bases_of(curves.curves);
  Controls& control = curves.curves.control[runtime::kRadiusEffect];
  for (Eigen::Index p = 0; p < control.rows(); ++p)
    control(p, 1) = share_by_width(curves, bases, p, radius_m);
  control = rounded_to_float(control);
  const IndenterTables tables(bases.views, radius_m, curves.curves.first_row_m, ends);
  const std::vector<PressedPoint> points = pressed_points(curves, others, bases, tables);
  RadiusReport found;
  std::vector<Effect> effect;
  std::vector<ForceError> own, theory, fitted;
  for (const PressedPoint& point : points) {
    effect.push_back(point.fit());
    point.errors(Effect::Zero(), theory);
    point.errors(effect.back(), fitted);
    for (std::size_t i = 0; i < point.force_N.size(); ++i)
      own.push_back({std::abs(point.as_own_ball_N[i] - point.force_N[i]), point.force_N[i]});
  }
  found.points = points.size();
  found.rows = theory.size();
  if (points.empty()) {
    if (report != nullptr) *report = found;
    return;
  }
  found.as_own_ball = relative_errors(own);
  found.theory = relative_errors(theory);
  found.fitted = relative_errors(fitted);
  found.left_out = found.theory;
  std::optional<bool> by_distance;
  for (const bool is_near : {true, false}) {
    std::vector<ForceError> left_out;
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].errors(
          effect_at(curves, points, effect, curves.position.row(points[i].point), i, is_near),
          left_out);
    const RelativeErrors is = relative_errors(left_out);
    if (points.size() > 1 && is.p95 + is.median < 0.95 * (found.theory.p95 + found.theory.median) &&
        is.p95 + is.median < found.left_out.p95 + found.left_out.median) {
      by_distance = is_near;
      found.left_out = is;
      found.chosen = is_near ? "near points' effect" : "mean effect";
    }
  }
  const auto add = [&control](Eigen::Index p, const Effect& more) {
    control.row(p) = bounded(control.row(p).transpose() + more).transpose();
  };
  for (Eigen::Index p = 0; by_distance && p < control.rows(); ++p)
    if (std::none_of(points.begin(), points.end(), [p](const auto& x) { return x.point == p; }))
      add(p,
          effect_at(curves, points, effect, curves.position.row(p), points.size(), *by_distance));
  for (std::size_t i = 0; i < points.size(); ++i) add(points[i].point, effect[i]);
  control = rounded_to_float(control);
  if (report != nullptr) *report = found;
}

}  // namespace palpate::fit
