// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// One step of a law on any surface and with any scalar: time passes where the body relaxes, the
// contact point slides, rings slip. The fitter's replay, tangents and the ablated
// tip of benchmarks take it as it is; the engine's contact does the same with its cached spot and
// looks at lift-off in between (contact/contact_law.hpp).

#include "families.hpp"

namespace palpate::runtime {

/// Result of a step.
template <class Kinematics, class T>
struct LawStep {
  Kinematics kinematics;  ///< at x, after the slide
  Answer<T> answer;
  bool has_slid;
};

/// The tool is at x [m]; left: what half of the tick's time leaves of each branch, where the body
/// relaxes. Derivatives are those of the branches that the step takes.
template <class F, class T, class Surface>
auto law_step(const CurveViews& views, const Vec3<T>& x, const Decay& left, Surface& surface,
              typename F::template Memory<T>& memory) noexcept
    -> LawStep<decltype(F::kinematics(views, surface.standing(), x, memory)), T> {
  auto kinematics = F::kinematics(views, surface.standing(), x, memory);
  const Vec3<T> from = kinematics.spot.point;
  Vec3<T> slip_position = x;
  bool relaxes = false;
  if constexpr (F::kCanRelax) {
    relaxes = F::relaxes(views);
    if (relaxes) {
      F::relax(views, kinematics, left, memory);
      slip_position = F::slip_position(views, kinematics, x, memory);
      kinematics = F::kinematics(views, surface.standing(), slip_position, memory);
    }
  }
  const bool has_slid =
      slide<F>(views, slip_position, surface, kinematics, memory) != SlideEnd::stick;
  if (has_slid) F::transport(views, memory, kinematics.spot.point - from, kinematics.spot.normal);
  if (has_slid || relaxes) kinematics = F::kinematics(views, surface.standing(), x, memory);
  const auto& bed = F::bed(views, kinematics);
  const auto response = F::slip(views, bed, kinematics, memory);
  return {kinematics, F::answer(views, bed, kinematics, response), has_slid};
}

}  // namespace palpate::runtime
