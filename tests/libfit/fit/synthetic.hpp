#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::test {

using Curve = std::function<double(double)>;

inline const FitOptions kSeparable{.family = CurveFamily::separable};

/// Samples grown one experiment at a time.
class Recorder {
 public:
  /// Index of a new test point; the gradient is du/dc [1/m].
  int add_point(const Vec3& inward, const Mat3& gradient = Mat3::Zero()) {
    const Eigen::Index p = samples.points();
    samples.point_position.conservativeResize(p + 1, 3);
    samples.point_position.row(p) = Vec3(0.01 * static_cast<double>(p), 0, 0);
    samples.point_normal.conservativeResize(p + 1, 3);
    samples.point_normal.row(p) = inward.normalized();
    samples.point_normal_gradient.conservativeResize(p + 1, 9);
    for (int k = 0; k < 9; ++k) samples.point_normal_gradient(p, k) = gradient(k / 3, k % 3);
    samples.point_name.emplace_back(1, static_cast<char>('a' + p % 26));
    return static_cast<int>(p);
  }

  void add(int point, ExperimentKind kind, const std::vector<Vec3>& deflection,
           const std::vector<Vec3>& force, double force_error_N = std::nan("")) {
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Eigen::Index n = samples.rows();
      samples.deflection.conservativeResize(n + 1, 3);
      samples.deflection.row(n) = deflection[i];
      samples.force.conservativeResize(n + 1, 3);
      samples.force.row(n) = force[i];
      samples.torque.conservativeResize(n + 1, 3);
      samples.torque.row(n).setZero();
      samples.force_error.conservativeResize(n + 1);
      samples.force_error[n] = force_error_N;
      samples.point.push_back(point);
      samples.experiment.push_back(experiments);
      samples.kind.push_back(kind);
      samples.step.push_back(static_cast<int>(i));
      samples.status.push_back(RowStatus::good);
    }
    ++experiments;
  }

  Vec3 inward(int point) const { return samples.point_normal.row(point); }
  /// A unit tangent at an angle.
  Vec3 tangent(int point, double angle) const {
    const Vec3 u = inward(point);
    const Vec3 side = u.unitOrthogonal();
    return std::cos(angle) * side + std::sin(angle) * u.cross(side);
  }

  /// Press along the normal to `depth_m` in equal steps.
  void press(int point, const Curve& normal, double depth_m, int steps) {
    std::vector<Vec3> deflection, force;
    for (int i = 1; i <= steps; ++i) {
      const double d = depth_m * i / steps;
      deflection.push_back(d * inward(point));
      force.push_back(normal(d) * inward(point));
    }
    add(point, ExperimentKind::press, deflection, force);
  }

  /// Drag on a flat surface: closed form, min(f^r, L) along the tangent.
  void flat_drag(int point, const Curve& normal, const Curve& lateral, const Curve& limit,
                 double depth_m, double travel_m, int steps, double angle) {
    std::vector<Vec3> deflection, force;
    const Vec3 u = inward(point), t = tangent(point, angle);
    for (int i = 0; i <= steps; ++i) {
      const double r = travel_m * i / steps;
      deflection.push_back(depth_m * u + r * t);
      force.push_back(normal(depth_m) * u + std::min(lateral(r), limit(depth_m)) * t);
    }
    add(point, ExperimentKind::drag, deflection, force);
  }

  Samples samples;
  int experiments = 0;
};

/// Straight rows of deflections for a drag.
inline std::vector<Vec3> drag_rows(const Vec3& u, const Vec3& t, double depth_m, double travel_m,
                                   int steps) {
  std::vector<Vec3> rows;
  for (int i = 0; i <= steps; ++i) rows.push_back(depth_m * u + travel_m * i / steps * t);
  return rows;
}

/// Pressed in, dragged out along t and back beyond where it began.
inline std::vector<Vec3> there_and_back(const Vec3& u, const Vec3& t, double depth_m,
                                        double travel_m) {
  std::vector<Vec3> rows;
  for (int i = 1; i <= 6; ++i) rows.push_back(depth_m * i / 6 * u);
  for (int i = 1; i <= 8; ++i) rows.push_back(depth_m * u + travel_m * i / 8 * t);
  for (int i = 1; i <= 12; ++i) rows.push_back(depth_m * u + travel_m * (1 - i / 8.0) * t);
  return rows;
}

/// Gaussian noise of one standard deviation on every force component.
inline void add_noise(Samples& samples, double deviation_N, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, deviation_N);
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    for (int k = 0; k < 3; ++k) samples.force(i, k) += noise(random);
}

/// One fitted curve of one point.
inline Curve fitted_curve(const FittedCurves& fitted, Eigen::Index point, CurveKind kind) {
  const auto k = static_cast<std::size_t>(kind);
  const SplineTables tables = tabulate(fitted.curves.basis[k]);
  const Eigen::VectorXd control = fitted.curves.control[k].row(point);
  return [tables, control](double x) {
    return runtime::curve_value(fit::view(tables), control.data(), x);
  };
}

/// Root mean square difference over root mean square of the truth, on (0, range].
inline double relative_rmse(const Curve& curve, const Curve& truth, double range) {
  double difference = 0, size = 0;
  for (int i = 1; i <= 400; ++i) {
    const double x = range * i / 400;
    difference += std::pow(curve(x) - truth(x), 2);
    size += std::pow(truth(x), 2);
  }
  return std::sqrt(difference / size);
}

/// Root mean square difference over the truth's largest value, on (0, range].
inline double full_scale_rmse(const Curve& curve, const Curve& truth, double range) {
  double difference = 0, largest = 0;
  for (int i = 1; i <= 400; ++i) {
    const double x = range * i / 400;
    difference += std::pow(curve(x) - truth(x), 2) / 400;
    largest = std::max(largest, truth(x));
  }
  return std::sqrt(difference) / largest;
}

}  // namespace palpate::test
