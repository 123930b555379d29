// What the interface remembers: friction limits lagged during a solution, states accepted after it.

#include <algorithm>
#include <cmath>

#include "libfem/contact/contact.hpp"

namespace palpate::fem {
namespace {

// A face whose outward normal points this far along the probe's own is the far wall of a thin body.
// Bulged surfaces ahead of a sunken sphere reach about 0.3.
constexpr double kFarWallCosine = 0.5;

}  // namespace

ContactHistory ContactInterface::untouched(const ProbePose& pose) const {
  return accepted({Points::Zero(nodes_.rows(), 3), pose, {}});
}

void ContactInterface::lag_friction_limit(const ContactHistory& history) {
  for (std::size_t point = 0; point < limit_Pa_.size(); ++point) {
    limit_Pa_[point] = probe_.friction * history.pressure_Pa[point];
    share_[point] = 1;
    normal_[point] = history.normal[point];
  }
}

void ContactInterface::lag_friction_limit(const ContactTrial& trial) {
  const auto& [u, pose, history] = trial;
  if (probe_.friction <= 0) return;
  for (int face = 0; face < faces_.rows(); ++face) {
    const FaceNodes nodes = nodes_of(u, face);
    const bool is_near = may_touch(pose, nodes, face);
    for (int q = 0; q < kFacePoints; ++q) {
      const int point = kFacePoints * face + q;
      limit_Pa_[point] = 0;
      if (!is_near || !history.faces_probe[point]) continue;
      const SignedDistance gap =
          distance(place_at(kFaceRule[q], nodes), probe_of(pose, history, point));
      const double pressing = pressing_gap(gap.distance_m, point, history);
      limit_Pa_[point] = probe_.friction * pressure_law(pressing, stiffness_[face]).pressure_Pa;
      if (limit_Pa_[point] <= 0) continue;
      share_[point] = share_in_contact(gap.distance_m, point, history);
      normal_[point] = gap.gradient;
    }
  }
}

ContactHistory ContactInterface::accepted(const ContactTrial& trial) const {
  const auto& [u, pose, history] = trial;
  ContactHistory next;
  const std::size_t points = area_weight_.size();
  next.stick_Pa.assign(points, Vec3::Zero());
  next.relative.resize(points);
  next.gap.resize(points);
  next.normal.resize(points);
  next.pressure_Pa.assign(points, 0.0);
  next.faces_probe.assign(points, 0);
  next.multiplier_m.assign(points, 0.0);
  next.is_second = history.is_second;
  if (pose.second) next.is_second.resize(points, 0);
  for (int face = 0; face < faces_.rows(); ++face) {
    const FaceNodes nodes = nodes_of(u, face);
    for (int q = 0; q < kFacePoints; ++q) {
      const int point = kFacePoints * face + q;
      const Vec3 x = place_at(kFaceRule[q], nodes);
      const bool is_free =
          pose.second && (history.gap.empty() ||
                          pressing_gap(distance(x, probe_of(pose, history, point)).distance_m,
                                       point, history) >= 0);
      if (is_free)
        next.is_second[point] =
            distance(x, *pose.second).distance_m < distance(x, {pose.tip, pose.axis}).distance_m;
      const SecondProbe probe = probe_of(pose, next, point);
      const SignedDistance gap = distance(x, probe);
      next.relative[point] = x - probe.tip;
      next.gap[point] = gap.distance_m;
      next.normal[point] = gap.gradient;
      const Vec3 outward = area_normal_at(kFaceRule[q], nodes).normalized();
      next.faces_probe[point] = outward.dot(gap.gradient) < kFarWallCosine;
      if (history.gap.empty() || is_free) continue;
      const double pressing = pressing_gap(gap.distance_m, point, history);
      if (pressing >= 0) continue;
      next.pressure_Pa[point] = pressure_law(pressing, stiffness_[face]).pressure_Pa;
      const double limit = probe_.friction * next.pressure_Pa[point];
      if (limit <= 0) continue;
      const double spring = tangential_ * stiffness_[face];
      const Friction friction =
          friction_law(next.relative[point], gap.gradient, limit,
                       share_in_contact(gap.distance_m, point, history), spring, point, history);
      next.stick_Pa[point] = friction.traction_Pa;
    }
  }
  return next;
}

ContactHistory ContactInterface::updated_multipliers(const ContactHistory& accepted) const {
  ContactHistory out = accepted;
  for (std::size_t point = 0; point < out.gap.size(); ++point) {
    if (out.pressure_Pa[point] <= 0) continue;
    out.multiplier_m[point] += std::max(0.0, -out.gap[point]);
    out.stick_Pa[point] *= 2;
  }
  return out;
}

}  // namespace palpate::fem
