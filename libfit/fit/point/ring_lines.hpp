#pragma once

#include <array>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/point/body_bases.hpp"

namespace palpate::fit {

/// Lines through the constants of a body's dragged points over the force of their presses
/// (RingPrior). log_force: one per point; constant: ln lambda, mu_0, mu_1 of each. deviation: of
/// a point's constants about the lines. Slopes are medians over pairs of points (Theil 1950, Sen
/// 1968, doi:10.1080/01621459.1968.10480934), drawn to 0 where the points' forces hardly differ; a
/// third of the points may be anything. Not for no point.
RingPrior ring_lines(const std::vector<double>& log_force,
                     const std::array<std::vector<double>, 3>& constant,
                     const std::array<double, 3>& deviation);

}  // namespace palpate::fit

namespace palpate {

/// The point whose drags would tell most: where the lines through the dragged points' constants
/// (method.md, section 17) are least certain, or the nearest dragged point is off them.
/// expected_error: of the force while sliding there, relative (M12c). point -1: all are dragged.
struct NextDrag {
  std::int32_t point = -1;
  double expected_error = 0;
};
NextDrag next_drag(const FittedCurves& curves, const std::vector<char>& is_dragged);

}  // namespace palpate
