#include "libfit/validation/predict.hpp"

#include <map>

#include "libfit/fit/point/replay.hpp"

namespace palpate::validation {
namespace {

// Rows of each experiment of a point that can be compared, in step order.
std::map<std::int32_t, std::vector<Eigen::Index>> usable_rows(const Samples& samples,
                                                              std::int32_t point) {
  std::map<std::int32_t, std::vector<Eigen::Index>> usable;
  std::map<std::int32_t, bool> has_ended;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (samples.point[r] != point) continue;
    const bool is_good = samples.status[r] == RowStatus::good;
    bool& ended = has_ended[samples.experiment[r]];
    if (is_good && !ended) usable[samples.experiment[r]].push_back(row);
    if (!is_good && samples.kind[r] != ExperimentKind::press) ended = true;
  }
  return usable;
}

}  // namespace

std::vector<ComparedRow> predicted_rows(const Samples& samples, std::int32_t point,
                                        const CurveSet& curves, Eigen::Index row) {
  const fit::Bases bases = fit::bases_of(curves);
  Mat3 gradient = Mat3::Zero();
  if (samples.point_normal_gradient.rows() != 0)
    for (int i = 0; i < 9; ++i) gradient(i / 3, i % 3) = samples.point_normal_gradient(point, i);
  const runtime::Quadric quadric = fit::quadric_of(samples.point_normal.row(point), gradient);
  const runtime::ControlPointers<double> controls = fit::controls_at(curves, row);
  std::vector<ComparedRow> compared;
  for (const auto& [experiment, rows] : usable_rows(samples, point)) {
    std::vector<double> deflection_m;
    for (const Eigen::Index i : rows)
      for (int k = 0; k < 3; ++k) deflection_m.push_back(samples.deflection(i, k));
    std::vector<runtime::Vec3d> force(rows.size());
    runtime::replay_drag<double>(bases.views, controls, quadric, deflection_m.data(),
                                 static_cast<int>(rows.size()), force.data());
    for (std::size_t i = 0; i < rows.size(); ++i)
      compared.push_back({samples.force.row(rows[i]), Vec3(force[i].x, force[i].y, force[i].z),
                          samples.force_error[rows[i]]});
  }
  return compared;
}

}  // namespace palpate::validation
