#include "libfit/shape/contact_states.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kTick_m = 20e-6;
constexpr double kApproachRatio = 0.1;

void go(const runtime::AssetView& asset, runtime::Contact& contact, const Vec3& from,
        const Vec3& to) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kTick_m)));
  runtime::Output out;
  for (int k = 1; k <= steps; ++k) {
    const Vec3 tip = from + (to - from) * (double(k) / steps);
    runtime::touch(asset, contact, tip.data(), out, nullptr, runtime::kMaxTimeStep_s);
  }
}

}  // namespace

std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples,
                                                            double depth_m) {
  std::vector<std::optional<runtime::Contact>> states(samples.point.size());
  runtime::Contact contact;
  Vec3 tip = Vec3::Zero();
  bool has_failed = false;
  for (std::size_t row = 0; row < states.size(); ++row) {
    const Vec3 point = samples.point_position.row(samples.point[row]),
               normal = samples.point_normal.row(samples.point[row]),
               deflection = samples.deflection.row(static_cast<Eigen::Index>(row));
    if (row == 0 || samples.experiment[row] != samples.experiment[row - 1]) {
      contact = runtime::Contact();
      has_failed = false;
      tip = point - kApproachRatio * depth_m * normal;
      go(asset, contact, tip, tip);
      const Vec3 down = point + deflection.dot(normal) * normal;
      if (samples.kind[row] == ExperimentKind::drag) {
        go(asset, contact, tip, down);
        tip = down;
      }
    }
    has_failed = has_failed || samples.status[row] != RowStatus::good;
    if (has_failed) continue;
    go(asset, contact, tip, point + deflection);
    tip = point + deflection;
    if (contact.triangle >= 0) states[row] = contact;
  }
  return states;
}

}  // namespace palpate
