// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A contact that is held grows tired: after a time t of contact it stores
//
//     Psi(E) = E (1 - a (1 - exp(-t / T)))
//
// and rests as soon as it lets go.

#include <cmath>

#include "../law/relaxation.hpp"
#include "../law/softening.hpp"
#include "contact.hpp"

namespace palpate {
namespace runtime {

struct AgeingMemory {
  static constexpr bool kFlows = true;
  static bool is_any(const AssetView& asset) noexcept { return asset.ageing != nullptr; }
  static Softened energy(const AssetView& asset, const ContactPoint& at, double law_J) noexcept {
    const double share = 1 - asset.ageing->share * at.age;
    return {law_J * share, share, 0};
  }
  static Softened load(const AssetView& asset, ContactPoint& at, double, double law_J) noexcept {
    return energy(asset, at, law_J);
  }
  template <class F, class Kinematics, class Memory>
  static void flow(const AssetView& asset, ContactPoint& at, const Kinematics&, const Decay& left,
                   Memory&) noexcept {
    at.age = 1 - (1 - at.age) * decay(left.dt_s / asset.ageing->time_s);
  }
};

}  // namespace runtime
}  // namespace palpate
