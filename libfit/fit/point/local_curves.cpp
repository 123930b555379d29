#include "libfit/fit/point/local_curves.hpp"

namespace palpate::fit {

LocalCurves curves_at(const Bases& bases, const CurveSet& curves, Eigen::Index row,
                      const Samples& samples, Eigen::Index point) {
  return {&bases, controls_at(curves, row),
          quadric_of(samples.point_normal.row(point), offset_gradient(samples, point))};
}

LocalAnswer local_answer(const LocalCurves& curves, const Points& way, const double* time_s,
                         const NuisanceValues& sensor) {
  std::vector<runtime::Vec3d> force(static_cast<std::size_t>(way.rows()));
  LocalAnswer out{Points(way.rows(), 3)};
  out.slipped_rows = replay<double>(curves.bases->views, curves.controls, curves.quadric,
                                    {way.data(), static_cast<int>(way.rows()), time_s},
                                    as_array(sensor), is_any(sensor), force.data());
  for (Eigen::Index i = 0; i < way.rows(); ++i) {
    const runtime::Vec3d& f = force[static_cast<std::size_t>(i)];
    out.force.row(i) << f.x, f.y, f.z;
  }
  return out;
}

LocalAnswer local_answer(const LocalCurves& curves, const Samples& samples,
                         const std::vector<Eigen::Index>& rows, const NuisanceValues& sensor) {
  const Points way = samples.deflection(rows, Eigen::all);
  if (samples.time_s.size() == 0) return local_answer(curves, way, nullptr, sensor);
  const Eigen::VectorXd time_s = samples.time_s(rows);
  return local_answer(curves, way, time_s.data(), sensor);
}

}  // namespace palpate::fit
