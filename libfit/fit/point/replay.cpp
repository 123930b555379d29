#include "libfit/fit/point/replay.hpp"

namespace palpate::fit {

LocalCurves curves_at(const Bases& bases, const CurveSet& curves, Eigen::Index row,
                      const Samples& samples, Eigen::Index point) {
  return {&bases, controls_at(curves, row),
          quadric_of(samples.point_normal.row(point), offset_gradient(samples, point))};
}

Eigen::Index point_at(const FittedCurves& curves, const Vec3& place) {
  Eigen::Index nearest = 0;
  const double distance_m =
      (curves.position.rowwise() - place.transpose()).rowwise().norm().minCoeff(&nearest);
  const bool is_there = distance_m <= 1e-6 * extent_m(curves.position).norm() &&
                        curves.status[nearest] != FitStatus::failed;
  return is_there ? nearest : -1;
}

LocalAnswer local_answer(const LocalCurves& curves, const Points& path, const double* time_s,
                         const NuisanceValues& sensor) {
  std::vector<runtime::Vec3d> force(path.rows());
  LocalAnswer out{Points(path.rows(), 3)};
  out.slipped_rows = replay<double>(curves.bases->views, curves.controls, curves.quadric,
                                    {path.data(), static_cast<int>(path.rows()), time_s}, sensor,
                                    is_any(sensor), force.data());
  for (Eigen::Index i = 0; i < path.rows(); ++i)
    out.force.row(i) << force[i].x, force[i].y, force[i].z;
  return out;
}

LocalAnswer local_answer(const LocalCurves& curves, const Samples& samples,
                         const std::vector<Eigen::Index>& rows, const NuisanceValues& sensor) {
  const Points path = samples.deflection(rows, Eigen::all);
  if (samples.time_s.size() == 0) return local_answer(curves, path, nullptr, sensor);
  const Eigen::VectorXd time_s = samples.time_s(rows);
  return local_answer(curves, path, time_s.data(), sensor);
}

}  // namespace palpate::fit
