#include <cmath>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

/// By how much the motion across the normal under a unit force along it differs from that of the
/// point's sway by (M33b); zero without a press.
Vec3 change_of_coupling(const PointData& point, const RingPrior& rings) {
  double most = 0, square = 0;
  Vec3 by_rings = Vec3::Zero(), by_sway = Vec3::Zero();  // motion, of rings times lambda
  for (const PointExperiment& e : point.experiments) {
    if (e.kind != ExperimentKind::press) continue;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const double along = e.force[i].dot(point.inward);
      if (!(along > 0)) continue;
      by_rings += depth_of(point, e.deflection[i]) * lateral_of(point, e.force[i]);
      by_sway += along * lateral_of(point, point.sway * e.force[i]);
      square += along * along;
      most = std::max(most, along);
    }
  }
  if (!(most > 0)) return Vec3::Zero();
  const double lambda = rings.at(std::log(point.force_N * most))[0];
  return -(by_rings / lambda + by_sway) / square;
}

}  // namespace

std::vector<Mat3> sways_of(const Samples& samples, double share) {
  std::vector<Mat3> out;
  for (const auto& numbers : samples.point_sway.rowwise())
    out.push_back(share * symmetric_of(numbers));
  return out;
}

std::vector<Mat3> turned_sways(const BodyData& body, std::vector<Mat3> sways,
                               const RingPrior& rings) {
  for (std::size_t p = 0; p < sways.size(); ++p) {
    const PointData& point = body.points[p];
    const Vec3 change = body.length_m / point.force_N * change_of_coupling(point, rings);
    const Mat3 turn = point.inward * change.transpose() + change * point.inward.transpose();
    // A thousandth of the largest stays positive when rounded to float.
    const auto is_sound = [](const Mat3& C) {
      const Vec3 values = symmetric_eigen(C).values;
      return values.minCoeff() >= 1e-3 * values.maxCoeff();
    };
    double share = 1;
    while (share > 1e-3 && !is_sound(sways[p] + share * turn)) share *= 0.9;
    if (share > 1e-3) sways[p] += share * turn;
  }
  return sways;
}

}  // namespace palpate::fit
