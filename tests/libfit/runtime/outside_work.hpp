#pragma once

// The work of a tool as somebody beside it measures it: the force that is shown, over the tool's
// own motion. It asks the engine's ledger nothing. What a sum over ticks errs by falls with their
// number, so ways are walked again in 4, 16 and 64 times as many ticks.

#include <algorithm>

#include "libfit/runtime/base/scalar.hpp"

namespace palpate::test {

constexpr int kFiner[] = {1, 4, 16, 64};
constexpr int kLevels = 4;
/// Of what was put in: what a way may seem to give in 64 times as many ticks.
constexpr double kMostGiven = 1e-3;

struct OutsideWork {
  double work_J = 0, in_J = 0;
  runtime::Vec3d before{0, 0, 0};  ///< force or torque on the tool at the tick before
  void add(const runtime::Vec3d& now, const runtime::Vec3d& step) {
    const double work = -0.5 * dot(before + now, step);
    work_J += work;
    in_J += std::max(work, 0.0);
    before = now;
  }
  double share() const { return in_J > 0 ? work_J / in_J : 0; }
};

}  // namespace palpate::test
