#include "libfit/fit/contact_effects.hpp"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/fit/point/replay.hpp"

namespace palpate::fit {
namespace {

// A cycle, with the energy and the force of the undamaged curve at its depths.
struct Cycle {
  std::vector<double> depth_m, law_J, law_N, force_N;
  double unit_J = 0, largest_N = 0;
};

// Force and work of a straight press without damage at each depth, from an even table.
class StraightPress {
 public:
  StraightPress(const LocalCurves& curves, const Vec3& inward, double deepest_m)
      : step_m_(deepest_m / kSteps) {
    Points path(kSteps, 3);
    for (int i = 1; i <= kSteps; ++i) path.row(i - 1) = step_m_ * i * inward;
    const Points force = local_answer(curves, path).force;
    force_N_.push_back(0);
    work_J_.push_back(0);
    for (int i = 0; i < kSteps; ++i) {
      const double now = inward.dot(Vec3(force.row(i)));
      work_J_.push_back(work_J_.back() + 0.5 * step_m_ * (force_N_.back() + now));
      force_N_.push_back(now);
    }
  }
  double force_N(double depth_m) const { return at(force_N_, depth_m); }
  double work_J(double depth_m) const { return at(work_J_, depth_m); }

 private:
  static constexpr int kSteps = 400;
  double at(const std::vector<double>& table, double depth_m) const {
    const double place = std::clamp(depth_m / step_m_, 0.0, double(kSteps));
    const auto i = static_cast<std::size_t>(std::min(place, kSteps - 1.0));
    return table[i] + (place - static_cast<double>(i)) * (table[i + 1] - table[i]);
  }
  double step_m_;
  std::vector<double> force_N_, work_J_;
};

std::vector<Cycle> cycles_of(const FittedCurves& curves, const Samples& samples) {
  const Bases bases = bases_of(curves.curves);
  std::map<std::int32_t, std::vector<Eigen::Index>> experiments;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) experiments[samples.experiment[i]].push_back(i);
  std::vector<Cycle> out;
  for (const auto& [number, rows] : experiments) {
    const Eigen::Index of_samples = samples.point[rows.front()];
    const Eigen::Index point = point_at(curves, samples.point_position.row(of_samples));
    const Vec3 inward = samples.point_normal.row(of_samples);
    double deepest_m = 0;
    bool is_straight = point >= 0;
    for (const Eigen::Index i : rows) {
      const Vec3 d = samples.deflection.row(i);
      deepest_m = std::max(deepest_m, d.dot(inward));
      is_straight = is_straight && (d - d.dot(inward) * inward).norm() <= 1e-6 * d.norm();
    }
    if (!is_straight || !(deepest_m > 0)) continue;
    const StraightPress press(curves_at(bases, curves.curves, point, samples, of_samples), inward,
                              deepest_m);
    Cycle cycle;
    const runtime::SplineView& normal = bases.views.view[runtime::kNormal];
    cycle.unit_J = runtime::curve_energy(normal, curves.curves.control[0].row(point).data(),
                                         normal.knots[normal.pieces]);
    double before_m = 0;
    bool goes_out = false;
    for (const Eigen::Index i : rows) {
      if (samples.status[i] != RowStatus::good) break;
      const double depth_m = samples.deflection.row(i).dot(inward);
      goes_out = goes_out || depth_m < before_m;
      before_m = depth_m;
      cycle.depth_m.push_back(depth_m);
      cycle.law_J.push_back(depth_m > 0 ? press.work_J(depth_m) : 0);
      cycle.law_N.push_back(depth_m > 0 ? press.force_N(depth_m) : 0);
      cycle.force_N.push_back(samples.force.row(i).dot(inward));
      cycle.largest_N = std::max(cycle.largest_N, cycle.force_N.back());
    }
    if (goes_out && cycle.largest_N > 0 && cycle.unit_J > 0) out.push_back(std::move(cycle));
  }
  return out;
}

// Visits each row of the cycles with what the damaged body answers and what was measured.
template <class Visit>
void answer(const std::vector<Cycle>& cycles, const runtime::DamageView& damage,
            const Visit& visit) {
  for (const Cycle& cycle : cycles) {
    double most_J = 0;
    for (std::size_t i = 0; i < cycle.law_J.size(); ++i) {
      most_J = std::max(most_J, cycle.law_J[i]);
      const double share =
          damage.softens() ? runtime::softened(damage, cycle.unit_J, most_J, cycle.law_J[i]).share
                           : 1;
      visit(cycle, share * cycle.law_N[i], cycle.force_N[i]);
    }
  }
}

std::vector<ForceError> errors(const std::vector<Cycle>& cycles,
                               const runtime::DamageView& damage) {
  std::vector<ForceError> out;
  answer(cycles, damage, [&](const Cycle&, double answered_N, double force_N) {
    out.push_back({std::abs(answered_N - force_N), std::abs(force_N)});
  });
  return out;
}

// The unknowns are logarithms, kept where a body can be.
runtime::DamageView damage_at(const Eigen::Vector3d& p) {
  const auto within = [](double x, double low, double high) {
    return std::clamp(std::exp(std::clamp(x, -50.0, 50.0)), low, high);
  };
  runtime::DamageView out;
  out.r = within(p[0], 1, 100);
  out.scale = within(p[1], 1e-6, 100);
  out.beta = within(p[2], 1e-6, 100);
  return out;
}

struct DamageResiduals {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };

  const std::vector<Cycle>& cycles;
  int rows;

  int NumResiduals() const { return rows; }
  Eigen::VectorXd at(const Eigen::Vector3d& p) const {
    Eigen::VectorXd out(rows);
    Eigen::Index i = 0;
    answer(cycles, damage_at(p), [&](const Cycle& cycle, double answered_N, double force_N) {
      out[i++] = (answered_N - force_N) / cycle.largest_N;
    });
    return out;
  }
  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const Eigen::Vector3d p = Eigen::Map<const Eigen::Vector3d>(parameters);
    Eigen::Map<Eigen::VectorXd>(residuals, rows) = at(p);
    if (jacobian == nullptr) return true;
    Eigen::Map<Eigen::MatrixXd>(jacobian, rows, 3) = slopes(p, 1e-5);
    return true;
  }
  Eigen::MatrixXd slopes(const Eigen::Vector3d& p, double by) const {
    Eigen::MatrixXd out(rows, 3);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = by * Eigen::Vector3d::Unit(k);
      out.col(k) = (at(p + step) - at(p - step)) / (2 * by);
    }
    return out;
  }
};

// Deviations of the logarithms, so relative ones, from the curvature of the squares and their
// minimum.
std::array<double, 3> deviations(const DamageResiduals& residuals, const Eigen::Vector3d& p) {
  const Eigen::MatrixXd slopes = residuals.slopes(p, 1e-3);
  const double variance = residuals.at(p).squaredNorm() / std::max(1, residuals.rows - 3);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(slopes.transpose() * slopes);
  std::array<double, 3> out{};
  for (int k = 0; k < 3; ++k) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const double part = std::pow(parts.eigenvectors()(k, i), 2);
      if (part > 1e-12) sum += part / std::max(1e-300, parts.eigenvalues()[i]);
    }
    out[k] = std::sqrt(variance * sum);
  }
  return out;
}

}  // namespace

runtime::DamageView identify_damage(const FittedCurves& curves, const Samples& samples,
                                    DamageReport* report) {
  const std::vector<Cycle> cycles = cycles_of(curves, samples);
  const std::vector<ForceError> undamaged = errors(cycles, {});
  DamageReport found;
  found.cycles = cycles.size();
  found.rows = undamaged.size();
  runtime::DamageView best;
  if (!cycles.empty()) {
    const DamageResiduals residuals{cycles, int(undamaged.size())};
    const auto rows = double(undamaged.size());
    double squares = 0;
    answer(cycles, {}, [&](const Cycle& cycle, double answered_N, double force_N) {
      squares += std::pow((answered_N - force_N) / cycle.largest_N, 2);
    });
    // A tenth off an error that is more than a thousandth of a cycle's largest force (rms).
    double least = squares > 1e-6 * rows ? 0.81 * squares : 0;
    std::vector<Eigen::Vector3d> starts;
    for (const double r : {1.2, 2.0, 5.0})
      for (const double beta : {0.1, 0.5})
        starts.emplace_back(std::log(r), std::log(0.02), std::log(beta));
    for (const Eigen::Vector3d& start : starts) {
      Eigen::Vector3d p = start;
      ceres::TinySolver<DamageResiduals> solver;
      solver.options.max_num_iterations = 300;
      solver.options.function_tolerance = solver.options.parameter_tolerance =
          solver.options.gradient_tolerance = 1e-12;
      solver.options.cost_threshold = 1e-18;
      solver.Solve(residuals, &p);
      const double left = residuals.at(p).squaredNorm();
      if (!(left < least)) continue;
      least = left;
      best = damage_at(p);
      found.deviation = deviations(residuals, p);
    }
    found.undamaged = relative_errors(undamaged);
    found.damaged = relative_errors(errors(cycles, best));
  }
  if (best.softens()) {
    const double radius_m = ball_radius_m(samples.probe ? samples.probe : curves.probe);
    best.reach_m = 1.5 * std::sqrt(radius_m * curves.curves.basis[0].knots_m.back());
  }
  if (report != nullptr) *report = found;
  return best;
}

}  // namespace palpate::fit
