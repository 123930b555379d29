// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Spin of a ball about the normal of its contact (docs/method.md, section 27). The rings of the
// contact's law resist it, too: ring i, which the method of dimensionality reduction has at the
// distance x_i from the axis, holds with k_i = 4 lambda / (2 - lambda) c_i x_i^2 until its friction
// is used up (M68), (M69).

#include "../families/ring_law.hpp"

namespace palpate {
namespace runtime {

/// Angles that the rings of one contact are twisted by [rad], and how stiff they were [N m].
struct Spin {
  double angle[kRings] = {}, stiffness_Nm[kRings] = {};
  bool is_twisted = false;
};
struct SpinAnswer {
  double torque_Nm = 0;  ///< on the body about the inward normal
  double stored_J = 0, lost_J = 0;
};

/// Square of the distance from the axis over depth [m]: the radius of the gap between ball and
/// body. Curvature of the surface that the ball's centre goes over, as a spot has it.
inline double spin_gap_m(double radius_m, const double curvature[6]) noexcept {
  const double mean = 0.5 * (curvature[0] + curvature[1] + curvature[2]);
  const double share = 1 - radius_m * mean;
  return radius_m * (share > 0.1 ? (share < 10 ? share : 10) : 0.1);
}

/// The tool turned by `turn` about the normal. Where a ring grows stiffer, because more of it
/// touches, the contact slides or the tool leans, what is new of it is not twisted, and its torque
/// stays: nobody is given energy. One that lateral friction uses has what is left (M69).
inline SpinAnswer spin_by(const RingTable<kRings>& table, const RingBed<double, kRings>& bed,
                          const RingDeflection<double>& at, const double* anchors, double gap_m,
                          double turn, Spin& spin) noexcept {
  constexpr double kHalfPi = 1.57079632679489662;
  SpinAnswer out;
  if (turn == 0 && !spin.is_twisted) return out;
  spin.is_twisted = true;
  const double lambda = bed.limit.lambda < 1 ? bed.limit.lambda : 1, d = at.depth_m;
  const double per = 4 / (2 - lambda), mu = bed.limit.friction_at(d);
  for (int i = 0; i < kRings; ++i) {
    const double from = i > 0 ? table.edge_m[i - 1] : 0;
    const double to = d < table.edge_m[i] ? d : table.edge_m[i];
    const double squared = gap_m * (i > 0 ? 0.5 * (from + to) : to / 3);
    double& angle = spin.angle[i];
    const double before = spin.stiffness_Nm[i];
    out.lost_J += 0.5 * before * angle * angle;
    double k = 0;
    if (to > from && lambda > 0) {
      k = per * bed.stiffness_N_m[i] * squared;
      if (to < table.edge_m[i]) k *= (to - from) / (table.edge_m[i] - from);
      if (k > before) angle *= before / k;
      out.lost_J -= 0.5 * k * angle * angle;
      angle += turn;
      const double work_J = 0.5 * k * angle * angle, reach = i > 0 ? d - 0.5 * (from + to) : d;
      const Vec3d q{at.q.x - anchors[i], at.q.y - anchors[kRings + i],
                    at.q.z - anchors[2 * kRings + i]};
      const double limit = mu * reach;  // on average where it touches
      double left = limit * limit - lambda * lambda * dot(q, q);
      // k angle is at most (pi / 2) x_i times the friction that is left, c_i sqrt(left).
      left = left > 0 ? kHalfPi * kHalfPi * left : 0;
      const double length = per * lambda, wanted = length * length * squared * (angle * angle);
      if (wanted > left) angle *= std::sqrt(left / wanted);
      out.torque_Nm += k * angle;
      out.stored_J += 0.5 * k * angle * angle;
      out.lost_J += work_J - 0.5 * k * angle * angle;
    } else {
      angle = 0;
    }
    spin.stiffness_Nm[i] = k;
  }
  return out;
}

}  // namespace runtime
}  // namespace palpate
