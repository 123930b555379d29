#pragma once

#include <string>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate {

/// The floor r_0 of the relative error that a statement gives of forces [N] (M11a): what a person
/// does not feel, or a tenth of the body's largest reference force where that is less. Rows at or
/// below it count in newtons alone.
double relative_floor_N(double largest_N);
/// The same of a body by its good rows; 0 without one.
double relative_floor_N(const Samples& reference);
/// The same of torques about the tool [N m] (M58a).
double relative_floor_Nm(double largest_Nm);

/// `quantile` of what counts, and no number where nothing does: NaN without values.
double stated_quantile(std::vector<double> values, double share);

/// 0.0213 is "2.1 %", no number is "-".
std::string stated_percent(double share);
/// 0.0043 is "4.3 mN".
std::string newtons(double force_N);

}  // namespace palpate
