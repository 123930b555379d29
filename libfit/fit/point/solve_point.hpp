#pragma once

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/point/start_values.hpp"

namespace palpate::fit {

/// Refines a point's identified curves so that replaying its experiments, friction limit
/// included, gives the forces recorded. Changes nothing where that does not lower the loss.
/// bases: in units of the body's length. One thread; deterministic.
void solve_point(const PointData& point, const Bases& bases, PointCurves& curves);

}  // namespace palpate::fit
