#include "libfit/fit/point/ring_lines.hpp"

#include <limits>

#include "libfit/core/node_forces.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fit {
namespace {

constexpr double kApart = 0.05;   // of ln force: pairs that are closer tell no slope
constexpr double kSpread = 0.05;  // sum of squares at which a slope counts half

}  // namespace

RingPrior ring_lines(const std::vector<double>& log_force,
                     const std::array<std::vector<double>, 3>& constant,
                     const std::array<double, 3>& deviation) {
  RingPrior out;
  out.is_of_drags = true;
  out.deviation = deviation;
  out.log_force = median(log_force);
  double square = 0;
  for (const double x : log_force) square += (x - out.log_force) * (x - out.log_force);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> slopes, level;
    for (std::size_t i = 0; i < log_force.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (const double apart = log_force[i] - log_force[j]; std::abs(apart) > kApart)
          slopes.push_back((constant[k][i] - constant[k][j]) / apart);
    if (!slopes.empty()) out.slope[k] = median(slopes) * square / (square + kSpread);
    for (std::size_t i = 0; i < log_force.size(); ++i)
      level.push_back(constant[k][i] - out.slope[k] * (log_force[i] - out.log_force));
    out.constant[k] = median(level);
  }
  return out;
}

}  // namespace palpate::fit

namespace palpate {

NextDrag next_drag(const FittedCurves& fitted, const std::vector<char>& is_dragged) {
  constexpr double kUsual[] = {0.1, 0.02};  // scatter of ln lambda and mu(D), as two points' worth
  constexpr double kSticking = 0.5;         // of the limit: what lambda decides while a drag sticks
  const NodeForces forces(fitted.curves);
  const double depth_m = fitted.curves.basis[0].knots_m.back();
  const Eigen::Index points = fitted.curves.points();
  std::vector<double> x, all_x;
  std::array<std::vector<double>, 3> y;
  std::vector<Eigen::Index> dragged;
  for (Eigen::Index p = 0; p < points; ++p) {
    const double force_N = forces.normal_N(p, depth_m);
    all_x.push_back(force_N > 0 ? std::log(force_N) : std::numeric_limits<double>::quiet_NaN());
    const double lambda = fitted.curves.control[runtime::kLambda](p, 0);
    if (is_dragged[static_cast<std::size_t>(p)] == 0 || !(force_N > 0 && lambda > 0)) continue;
    dragged.push_back(p);
    x.push_back(all_x.back());
    y[0].push_back(std::log(lambda));
    y[1].push_back(forces.limit_N(p, depth_m) / force_N);
    y[2].push_back(0);
  }
  NextDrag best;
  if (dragged.empty()) return best;
  const fit::RingPrior lines = fit::ring_lines(x, y, {});
  const auto n = static_cast<double>(x.size());
  double mean = 0, square = fit::kSpread;
  for (const double each : x) mean += each / n;
  for (const double each : x) square += (each - mean) * (each - mean);
  std::array<std::vector<double>, 2> off;  // of dragged points, from the lines
  std::array<double, 2> variance{};
  for (std::size_t k = 0; k < 2; ++k) {
    variance[k] = 2 * kUsual[k] * kUsual[k];
    for (std::size_t i = 0; i < x.size(); ++i) {
      off[k].push_back(
          std::abs(y[k][i] - lines.constant[k] - lines.slope[k] * (x[i] - lines.log_force)));
      variance[k] += off[k].back() * off[k].back();
    }
    variance[k] /= n;
  }
  for (Eigen::Index p = 0; p < points; ++p) {
    const double at = all_x[static_cast<std::size_t>(p)];
    if (is_dragged[static_cast<std::size_t>(p)] != 0 || !std::isfinite(at)) continue;
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < dragged.size(); ++i)
      if ((fitted.position.row(dragged[i]) - fitted.position.row(p)).norm() <
          (fitted.position.row(dragged[nearest]) - fitted.position.row(p)).norm())
        nearest = i;
    const double share = 1 / n + (at - mean) * (at - mean) / square;
    const auto deviation = [&](std::size_t k) {
      return std::sqrt(variance[k] * share + off[k][nearest] * off[k][nearest]);
    };
    const double mu = std::max(lines.constant[1] + lines.slope[1] * (at - lines.log_force), 0.0);
    const double error = std::hypot(kSticking * mu * deviation(0), deviation(1));
    if (error > best.expected_error) best = {static_cast<std::int32_t>(p), error};
  }
  return best;
}

}  // namespace palpate
