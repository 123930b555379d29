#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "libfem/solve/experiments/experiment_plan.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/relaxation.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fem {

/// Depths at which normal forces are those that a path asks for (M14d): proposed from the forces
/// that earlier proposals met. How far along the normal a step may go is where the path has it.
class HeldDepths {
 public:
  HeldDepths(const ToolPath& path, const Vec3& normal, const Relaxation& series)
      : normal_(normal), limits_(path.deflections), held_N_(path.held_N) {
    const Eigen::Index n = limits_.rows();
    most_m_ = limits_ * normal;
    depth_m_ = most_m_;
    while (first_ < n && !is_asked(first_)) ++first_;
    stiffening_ = Eigen::MatrixXd::Ones(n, n);
    for (Eigen::Index i = 0; i < n && path.time_s.size() > 0; ++i)
      for (Eigen::Index j = 0; j <= i; ++j)
        stiffening_(i, j) = mean_stiffening(series, path.time_s[i] - path.time_s[j],
                                            path.time_s[i] - (j > 0 ? path.time_s[j - 1] : 0.0));
    depth_m_[first_] /= 2;  // a start
    const Eigen::VectorXd model = model_forces();
    propose(Eigen::VectorXd::Constant(n, held_N_[first_] / model[first_]));
  }

  /// Rows of the path at the depths that are proposed; meshes of the plan stay as they are.
  void place(ExperimentPlan& plan) const {
    for (PathTarget& target : plan.paths[0].targets) {
      const Eigen::Index i = target.row;
      target.deflection = Vec3(limits_.row(i)) - (most_m_[i] - depth_m_[i]) * normal_;
      plan.rows[static_cast<std::size_t>(i)].deflection = target.deflection;
    }
  }

  /// The first row whose force is not what is asked for; as many as there are rows: none.
  Eigen::Index first_unmet(const std::vector<PointRow>& rows, double tolerance) const {
    Eigen::Index i = 0;
    for (; i < held_N_.size(); ++i) {
      if (!is_asked(i)) continue;
      const PointRow& row = rows[static_cast<std::size_t>(i)];
      if (row.status != RowStatus::good ||
          !(std::abs(row.force.dot(normal_) - held_N_[i]) <= tolerance * held_N_[i]))
        break;
    }
    return i;
  }
  /// Whether nothing is left to seek: all is met, or the force is too small as deep as may be.
  bool is_over(const std::vector<PointRow>& rows, double tolerance) const {
    const Eigen::Index i = first_unmet(rows, tolerance);
    if (i == held_N_.size()) return true;
    const PointRow& row = rows[static_cast<std::size_t>(i)];
    return row.status == RowStatus::good && depth_m_[i] == most_m_[i] &&
           row.force.dot(normal_) < held_N_[i];
  }

  /// Proposes depths anew. rows: solved along the ones before.
  void learn(const std::vector<PointRow>& rows) {
    const auto force_N = [&](Eigen::Index i) {
      const PointRow& row = rows[static_cast<std::size_t>(i)];
      return row.status == RowStatus::good ? row.force.dot(normal_) : 0.0;
    };
    // The force of the first hangs on its depth alone and so tells the power.
    const double here_N = force_N(first_), here_m = depth_m_[first_];
    const double way = std::log(here_m / before_m_);
    if (here_N > 0 && before_N_ > 0 && std::abs(way) > kLeastWay)
      power_ = std::clamp(std::log(here_N / before_N_) / way, kLeastPower, kMostPower);
    before_N_ = here_N, before_m_ = here_m;
    const Eigen::VectorXd model = model_forces();
    Eigen::VectorXd gain(model.size());
    double last = here_N > 0 ? here_N / model[first_] : 2 * held_N_[first_] / model[first_];
    for (Eigen::Index i = 0; i < gain.size(); ++i)
      gain[i] = last = force_N(i) > 0 && model[i] > 0 ? force_N(i) / model[i] : last;
    propose(gain);
  }

 private:
  static constexpr double kLeastWay = 0.01, kLeastPower = 1, kMostPower = 4;
  static constexpr double kShallowest = 1e-4;  // of the deepest

  bool is_asked(Eigen::Index i) const { return !std::isnan(held_N_[i]); }
  double lifted(double depth_m) const { return std::pow(std::max(depth_m, 0.0), power_); }

  // Of a body after a motion at even pace, from `since_s` ago to `until_s` ago.
  static double mean_stiffening(const Relaxation& series, double until_s, double since_s) {
    double out = 1;
    for (Eigen::Index k = 0; k < series.branches(); ++k) {
      const double tau_s = series.time_s[k], dt = (since_s - until_s) / tau_s;
      out += series.share[k] * std::exp(-until_s / tau_s) * (dt > 0 ? -std::expm1(-dt) / dt : 1);
    }
    return out;
  }
  Eigen::VectorXd model_forces() const {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(depth_m_.size());
    for (Eigen::Index i = 0; i < out.size(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j)
        out[i] +=
            stiffening_(i, j) * (lifted(depth_m_[j]) - (j > 0 ? lifted(depth_m_[j - 1]) : 0.0));
    return out;
  }
  // Depths where the model's forces, times the gains, are what is asked for.
  void propose(const Eigen::VectorXd& gain) {
    for (Eigen::Index i = 0; i < gain.size(); ++i) {
      if (!is_asked(i)) continue;
      double remembered = 0, before = 0;
      for (Eigen::Index j = 0; j < i; ++j) {
        const double here = lifted(depth_m_[j]);
        remembered += stiffening_(i, j) * (here - before);
        before = here;
      }
      const double there = before + (held_N_[i] / gain[i] - remembered) / stiffening_(i, i);
      depth_m_[i] = std::clamp(std::pow(std::max(there, 0.0), 1 / power_), kShallowest * most_m_[i],
                               most_m_[i]);
    }
  }

  Vec3 normal_;
  Points limits_;
  Eigen::VectorXd held_N_, most_m_, depth_m_;
  Eigen::MatrixXd stiffening_;
  Eigen::Index first_ = 0;  // that is asked for
  double power_ = 1.5;      // of depth, as Hertz has it
  double before_N_ = 0, before_m_ = 1;
};

}  // namespace palpate::fem
