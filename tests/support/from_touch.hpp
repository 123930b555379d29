#pragma once

#include "libfit/runtime/law/families.hpp"

namespace palpate::test {

/// What a tool at x [m] does to the body whose contact point is the spot, from first touch on
/// without a slip.
template <class T, class Spot>
runtime::Answer<T> answer_from_touch(const runtime::CurveViews& views, const Spot& spot,
                                     const runtime::Vec3<T>& x) noexcept {
  return runtime::with_family(views, [&](auto f) noexcept {
    const auto memory = f.template load<T>(runtime::no_memory());
    const auto kinematics = f.kinematics(views, spot, x, memory);
    const auto& bed = f.bed(views, kinematics);
    return f.answer(views, bed, kinematics, f.stick(views, bed, kinematics, memory));
  });
}
template <class T, class Spot>
runtime::Vec3<T> force_from_touch(const runtime::CurveViews& views, const Spot& spot,
                                  const runtime::Vec3<T>& x) noexcept {
  return answer_from_touch(views, spot, x).force_N;
}
template <class T, class Spot>
T energy_from_touch_J(const runtime::CurveViews& views, const Spot& spot,
                      const runtime::Vec3<T>& x) noexcept {
  return answer_from_touch(views, spot, x).stored_J;
}

}  // namespace palpate::test
