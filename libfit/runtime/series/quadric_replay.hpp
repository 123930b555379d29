// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The law predicting a record: presses, drags and paths on the quadric around a test point, for the
// fitter (scalar double or ceres::Jet) and for who compares samples with curves.

#include "../law/step.hpp"
#include "../surface/quadric.hpp"
#include "compliance.hpp"

namespace palpate::runtime {

/// One contact in series with the body's sway at a test point.
class SeriesPoint {
 public:
  explicit SeriesPoint(const Compliance& compliance) noexcept : is_compliant_(compliance.is_any()) {
    const double* c = compliance.c;
    const double own[9] = {c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2]};
    compliance_.count = 1;
    std::memcpy(compliance_.block[0][0], own, sizeof own);
  }
  bool is_compliant() const noexcept { return is_compliant_; }

  /// The force of a tool at x; left: of half of the time since the last one. respond(y): the law's
  /// answer to a tool at y; its last call is with the force that is returned.
  template <class Respond>
  Vec3d settle_at(const RelaxationView& relaxation, const Vec3d& x, const Decay& left,
                  const Respond& respond) noexcept {
    const Vec3d slow = slow_force(relaxation, memory_, memory_.force());
    relax_compliance(relaxation, left, slow, memory_);
    const Vec3d flowed = rest_force(relaxation, memory_);
    SeriesForces s;
    s.compliance = &compliance_;
    s.share = 1 / relaxation.fast;
    s.rest[0] = x - compliance_.displacement(0, &flowed);
    s.force[0] = memory_.force();
    s.stiffness[0] = memory_.slipping_N_m;
    Vec3d answer{0, 0, 0};
    const Vec3d before = relative_m_;
    SeriesMatrix matrix;
    settle(s, matrix, &before, [&](int, const Vec3d& y) noexcept {
      relative_m_ = y;
      return answer = respond(y);
    });
    put(s.force[0] + s.correction_N[0], memory_.force_N);
    return answer;
  }

 private:
  bool is_compliant_;
  ComplianceMatrix compliance_;
  SeriesMemory memory_;
  Vec3d relative_m_{0, 0, 0};
};

/// A contact on a quadric between two rows of a replay.
template <class F, class T>
struct QuadricContact {
  QuadricSurface<T> surface;
  typename F::template Memory<T> memory;
  bool is_first = true, in_contact = true, has_slipped = false;
  Vec3d before{0, 0, 0};
  Vec3<T> tool{T(0), T(0), T(0)};  ///< where it was last

  QuadricContact(const CurveViews& views, const Quadric& quadric,
                 const ControlPointers<T>& controls) noexcept
      : surface{&quadric, controls, {T(0), T(0), T(0)}},
        memory(F::template load<T>(no_memory(), views.relaxation)) {}

  /// The force on the body of a tool that goes to x. left: of half of the time that this takes,
  /// where the body relaxes.
  Vec3<T> go_to(const CurveViews& views, const Vec3<T>& x, const Decay& left) noexcept {
    const Quadric& quadric = *surface.quadric;
    const Vec3d tip = values_of(x);
    has_slipped = false;
    if (!in_contact && depth_below(quadric, before) <= 0 && depth_below(quadric, tip) > 0) {
      surface.p = widened<T>(entry_shadow(quadric, before, tip));
      memory = F::template load<T>(no_memory(), views.relaxation);
      tool = widened<T>(before);
      in_contact = true;
    }
    before = tip;
    if (!in_contact) return {T(0), T(0), T(0)};
    if constexpr (F::kCanRelax)
      if (F::relaxes(views))
        F::relax(views, F::kinematics(views, surface.standing(), tool, memory), left, memory);
    tool = x;
    const auto step = law_step<F>(views, x, left, surface, memory);
    has_slipped = step.has_slid;
    in_contact = value_of(step.kinematics.d.normal_m) > 0 || is_first;
    is_first = false;
    return step.answer.force_N;
  }
};

/// The compliance among a point's numbers, with plain numbers; with derivatives none: rows that a
/// fit replays are without the sway.
template <class F, class T>
Compliance compliance_of(const ControlPointers<T>& controls) noexcept {
  Compliance out;
  if constexpr (F::kSwayPart >= 0 && std::is_same<T, double>::value)
    for (int i = 0; i < 6; ++i) out.c[i] = controls.part[F::kSwayPart][i];
  return out;
}

/// Into how many ticks a replay divides a row in which the tool moves: the law lets dashpots flow
/// for half of a tick at either end, so a branch's force errs by 1/24 (dt/time)^2, 1/1500 of it at
/// these. The cap is for branches that are over long before the row is.
constexpr double kTicksPerRelaxation = 8;
constexpr int kMaxReplayTicks = 64;
inline int replay_ticks(const RelaxationView& relaxation, double dt_s, bool moves) noexcept {
  if (relaxation.branches == 0 || !moves) return 1;
  const double wanted = kTicksPerRelaxation * dt_s / relaxation.time_s[0];
  return wanted < kMaxReplayTicks ? 1 + static_cast<int>(wanted) : kMaxReplayTicks;
}

/// The rows of a replay: rows x 3 [m], tool position relative to the test point, in order, and when
/// each was reached [s] since first touch. time_s: null where rows are of slow motion.
struct ReplayedRows {
  const double* deflection_m;
  int rows;
  const double* time_s = nullptr;
};

/// Forces of the tool on the body along one press, drag or path: the law predicting a record. The
/// first touch is at the test point, later ones (after a lift) where the path_m enters the body.
/// deeper_m: how much deeper along the inward normal the tool was. force_N: rows results. The
/// contact is carried from row to row; each row is one tick of the engine, or more where the body
/// relaxes, so steps should not be much longer than the lateral deflection at which the tool slips.
/// A body that relaxes answers rows without time as in slow motion. Returns how many rows slipped.
/// Derivatives flow through every slip's root.
template <class F, class T>
int replay_as(const CurveViews& any_time, const ControlPointers<T>& controls,
              const Quadric& quadric, const ReplayedRows& record, const T* deeper_m,
              Vec3<T>* force_N) noexcept {
  CurveViews slow;
  const bool is_slow = record.time_s == nullptr && F::relaxes(any_time);
  if (is_slow) {
    slow = any_time;
    slow.relaxation = RelaxationView();
  }
  const CurveViews& views = is_slow ? slow : any_time;
  QuadricContact<F, T> contact(views, quadric, controls);
  SeriesPoint point(compliance_of<F>(controls));
  int slipped = 0;
  Vec3<T> from{T(0), T(0), T(0)};
  for (int row = 0; row < record.rows; ++row) {
    Vec3<T> x = widened<T>(make_vec3<double>(record.deflection_m + 3 * row));
    if (deeper_m != nullptr) x = x + widened<T>(quadric.u0) * *deeper_m;
    const Vec3<T> path_m = x - from;
    const double dt_s =
        record.time_s == nullptr ? 0 : record.time_s[row] - (row > 0 ? record.time_s[row - 1] : 0);
    const int ticks = F::relaxes(views)
                          ? replay_ticks(views.relaxation, dt_s, value_of(dot(path_m, path_m)) > 0)
                          : 1;
    const Decay left = decay_over(views.relaxation, 0.5 * dt_s / ticks);
    bool has_slipped = false;
    for (int tick = 1; tick <= ticks; ++tick) {
      const Vec3<T> at = tick == ticks ? x : from + path_m * (double(tick) / ticks);
      bool is_done = false;
      if constexpr (std::is_same<T, double>::value) {
        if (point.is_compliant()) {
          const QuadricContact<F, T> start = contact;
          force_N[row] = point.settle_at(views.relaxation, at, left, [&](const Vec3d& y) noexcept {
            contact = start;
            return contact.go_to(views, y, left);
          });
          is_done = true;
        }
      }
      if (!is_done) force_N[row] = contact.go_to(views, at, left);
      has_slipped |= contact.has_slipped;
    }
    from = x;
    slipped += has_slipped;
  }
  return slipped;
}
template <class T>
int replay_drag(const CurveViews& views, const ControlPointers<T>& controls, const Quadric& quadric,
                const ReplayedRows& record, const T* deeper_m, Vec3<T>* force_N) noexcept {
  return with_family(views, [&](auto f) noexcept {
    return replay_as<decltype(f)>(views, controls, quadric, record, deeper_m, force_N);
  });
}

template <class T>
int replay_drag(const CurveViews& views, const ControlPointers<T>& controls, const Quadric& quadric,
                const double* deflection_m, int rows, Vec3<T>* force_N) noexcept {
  return replay_drag<T>(views, controls, quadric, {deflection_m, rows}, nullptr, force_N);
}

}  // namespace palpate::runtime
