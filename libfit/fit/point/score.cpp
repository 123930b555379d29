#include "libfit/fit/point/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/geometry.hpp"
#include "libfit/fit/point/local_curves.hpp"

namespace palpate::fit {
Eigen::VectorXd stored_controls(const Eigen::VectorXd& increments, double force_N,
                                bool is_strictly_rising) {
  Eigen::VectorXd control = controls_of(increments) * force_N;
  float last = 0;
  for (Eigen::Index j = 1; j < control.size(); ++j) {
    auto rounded = static_cast<float>(control[j]);  // to nearest keeps order, but may meet
    if (!(rounded >= last)) rounded = last;
    if (is_strictly_rising && !(rounded > last))
      rounded = std::nextafter(last, std::numeric_limits<float>::infinity());
    control[j] = static_cast<double>(rounded);
    last = rounded;
  }
  return control;
}

Eigen::VectorXd stored_part(const runtime::Part& part, const PointData& point,
                            const Eigen::VectorXd& unknowns, double length_m) {
  const std::vector<double> control = part_controls<double>(
      part, tangents_of(point.inward), quadric_of(point.inward, point.normal_gradient),
      unknowns.data(), static_cast<int>(unknowns.size()), point.sway);
  const double unit = std::pow(length_m, part.length) * std::pow(point.force_N, part.force);
  Eigen::VectorXd stored(static_cast<Eigen::Index>(control.size()));
  for (std::size_t j = 0; j < control.size(); ++j)
    stored[static_cast<Eigen::Index>(j)] =
        rounded_to_float(std::clamp(unit * control[j], part.min, part.max));
  return stored;
}

PointScore score_point(const Samples& samples, const PointData& point, double length_m,
                       const Bases& bases_m, const std::vector<Eigen::VectorXd>& controls,
                       const std::vector<NuisanceValues>& nuisance) {
  const LocalCurves curves{&bases_m, pointers_to<double>(controls),
                           quadric_of(point.inward, point.normal_gradient / length_m)};
  PointScore score;
  double square = 0, force_square = 0, rows = 0;
  for (std::size_t at = 0; at < point.experiments.size(); ++at) {
    const PointExperiment& e = point.experiments[at];
    const LocalAnswer answer =
        local_answer(curves, samples, e.row, nuisance.empty() ? NuisanceValues{} : nuisance[at]);
    score.slipped_rows += answer.slipped_rows;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const Vec3 measured = samples.force.row(e.row[i]);
      const double size = (Vec3(answer.force.row(static_cast<Eigen::Index>(i))) - measured).norm();
      square += size * size, force_square += measured.squaredNorm(), ++rows;
      score.rows.push_back({size, measured.norm()});
      if (size > score.max_N || rows == 1) {
        score.max_N = size;
        score.worst_experiment = e.id;
        score.worst_row = i;
      }
    }
  }
  score.rms_N = std::sqrt(square / rows);
  score.relative = std::sqrt(square / force_square);
  return score;
}

}  // namespace palpate::fit
