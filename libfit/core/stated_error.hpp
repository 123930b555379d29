#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate {

/// The one relative error (M11a): |difference| over |reference|, and where the reference is below a
/// floor, over the floor. Without one the first rows of a press, where force goes to zero, would be
/// all that a quantile sees. error, force and floor: in one unit, not negative.
inline double relative_error(double error, double force, double floor) {
  return error / std::max(force, floor);
}

/// The floor r_0 of errors by which something is decided or weighed, in the unit of `largest`: a
/// tenth of that. A stiffer body leaves such decisions as they are.
double relative_floor(double largest);
/// The floor r_0 of errors that are stated [N] (M11a): what a person does not feel, or
/// relative_floor() of the body's largest reference force where that is less. Rows at or below it
/// count in newtons alone.
double relative_floor_N(double largest_N);
/// The same of a body by its good rows; 0 without one.
double relative_floor_N(const Samples& reference);
/// The same of torques [N m], by that force at a lever (M58a).
double relative_floor_Nm(double largest_Nm, double lever_m);

struct ForceError {
  double error_N, force_N;  ///< |difference|, |reference|
};
/// Relative errors as a statement has them: of the rows above relative_floor_N of their largest.
std::vector<double> stated_errors(const std::vector<ForceError>& rows);

/// Figures of relative differences.
struct RelativeErrors {
  double median = 0, p95 = 0, max = 0;
};
/// Those of the stated errors.
RelativeErrors relative_errors(const std::vector<ForceError>& rows);

/// `quantile` of what counts, and no number where nothing does: NaN without values.
double stated_quantile(std::vector<double> values, double share);

/// 0.0213 is "2.1 %", no number is "-".
std::string stated_percent(double share);
/// 0.0043 is "4.3 mN".
std::string newtons(double force_N);

}  // namespace palpate
