#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "libfit/runtime/contact/body.hpp"

namespace palpate {

// How experiments are followed with the engine, to compare its answers.

inline constexpr double kWalkTick_m = 20e-6;   ///< most that a tool moves: 20 mm/s at 1 kHz
inline constexpr double kApproachRatio = 0.1;  ///< of the depth, from outside, before the first row

/// An asset with a body of its own where contacts damage one.
class WalkedBody {
 public:
  explicit WalkedBody(const runtime::AssetView& asset)
      : view_(asset), memory_(asset.damage.softens() ? runtime::body_bytes(asset) / 8 : 0) {
    if (!memory_.empty()) view_ = runtime::with_body(asset, memory_.data());
  }
  WalkedBody(const WalkedBody&) = delete;
  WalkedBody& operator=(const WalkedBody&) = delete;

  /// The body as it was before any touch.
  const runtime::AssetView& fresh() {
    if (!memory_.empty()) runtime::start_body(view_, memory_.data());
    return view_;
  }

 private:
  runtime::AssetView view_;
  std::vector<std::uint64_t> memory_;
};

/// Ticks over a way [m]; at least one.
inline int ticks_over(double way_m) {
  return std::max(1, static_cast<int>(std::ceil(way_m / kWalkTick_m)));
}

}  // namespace palpate
