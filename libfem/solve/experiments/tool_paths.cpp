#include "libfem/solve/experiments/tool_paths.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace palpate::fem {
namespace {

// Depths over the deepest: in and out, twice, and in.
constexpr std::array kCycle{0.17, 0.33, 0.5, 0.4, 0.25, 0.1, 0.25, 0.4, 0.5, 0.75,
                            1.0,  0.85, 0.7, 0.5, 0.3,  0.1, 0.3,  0.6, 0.8, 1.0};
// A press beforehand; the last row is out of touch.
constexpr std::array kBefore{0.3, 0.65, 1.0, 0.5, -0.05};

}  // namespace

ToolPath cycled_press(int point, const Vec3& inward, double depth_m) {
  ToolPath path{point, Points(kCycle.size(), 3)};
  for (std::size_t i = 0; i < kCycle.size(); ++i)
    path.deflections.row(i) = kCycle[i] * depth_m * inward.transpose();
  return path;
}

ToolPath after_press(const ToolPath& path, const Vec3& inward, double preload_m) {
  constexpr auto kRows = static_cast<Eigen::Index>(kBefore.size());
  ToolPath out = path;
  out.time_s = {};  // in slow motion, as the press before it
  out.deflections.resize(kRows + path.deflections.rows(), 3);
  for (Eigen::Index i = 0; i < kRows; ++i)
    out.deflections.row(i) = kBefore[i] * preload_m * inward.transpose();
  out.deflections.bottomRows(path.deflections.rows()) = path.deflections;
  return out;
}

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
  ToolPath out = path;
  out.deflections.resize(place.size(), 3);
  out.time_s = Eigen::Map<const Eigen::VectorXd>(time_s.data(), time_s.size());
  for (std::size_t i = 0; i < place.size(); ++i) out.deflections.row(i) = place[i].transpose();
  return out;
}

}  // namespace palpate::fem
