#include "libfem/solve/experiments/timed_path.hpp"

#include <cmath>
#include <vector>

namespace palpate::fem {

ToolPath in_time(const ToolPath& path, double speed_m_s, double hold_s) {
  constexpr double kHoldDecades = 2;
  std::vector<Vec3> place;
  std::vector<double> time_s;
  Vec3 at = Vec3::Zero();
  double now_s = 0;
  for (Eigen::Index i = 0; i < path.deflections.rows(); ++i) {
    const Vec3 next = path.deflections.row(i);
    const double takes_s = (next - at).norm() / speed_m_s;
    at = next;
    if (!(now_s + takes_s > now_s)) continue;
    place.push_back(at);
    time_s.push_back(now_s += takes_s);
  }
  for (int k = 1; k <= kHoldRows && hold_s > 0; ++k) {
    place.push_back(at);
    time_s.push_back(now_s +
                     hold_s * std::pow(10, kHoldDecades * (k - kHoldRows) / (kHoldRows - 1)));
  }
  ToolPath out{
      path.point, Points(static_cast<Eigen::Index>(place.size()), 3),
      Eigen::Map<const Eigen::VectorXd>(time_s.data(), static_cast<Eigen::Index>(time_s.size())),
      path.lean};
  for (std::size_t i = 0; i < place.size(); ++i)
    out.deflections.row(static_cast<Eigen::Index>(i)) = place[i].transpose();
  return out;
}

}  // namespace palpate::fem
