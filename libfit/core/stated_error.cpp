#include "libfit/core/stated_error.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/perception.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"

namespace palpate {

double relative_floor(double largest) { return 0.1 * largest; }

double relative_floor_N(double largest_N) {
  return std::min(perception().force_floor_N, relative_floor(largest_N));
}

double relative_floor_N(const Samples& reference) {
  double largest_N = 0;
  for (Eigen::Index row = 0; row < reference.rows(); ++row)
    if (reference.status[row] == RowStatus::good)
      largest_N = std::max(largest_N, reference.force.row(row).norm());
  return relative_floor_N(largest_N);
}

double relative_floor_Nm(double largest_Nm, double lever_m) {
  return std::min(perception().force_floor_N * lever_m, relative_floor(largest_Nm));
}

std::vector<double> stated_errors(const std::vector<ForceError>& rows) {
  double largest_N = 0;
  for (const ForceError& row : rows) largest_N = std::max(largest_N, row.force_N);
  const double floor_N = relative_floor_N(largest_N);
  std::vector<double> out;
  for (const auto& [error_N, force_N] : rows)
    if (force_N > floor_N) out.push_back(relative_error(error_N, force_N, floor_N));
  return out;
}

RelativeErrors relative_errors(const std::vector<ForceError>& rows) {
  const std::vector<double> errors = stated_errors(rows);
  return {median(errors), quantile(errors, 0.95), quantile(errors, 1)};
}

double stated_quantile(std::vector<double> values, double share) {
  return values.empty() ? kNan : quantile(std::move(values), share);
}

std::string stated_percent(double share) { return std::isnan(share) ? "-" : percent(share); }

std::string newtons(double force_N) {
  if (force_N >= 1 || force_N == 0) return number(force_N) + " N";
  return force_N >= 1e-3 ? number(1e3 * force_N) + " mN" : number(1e6 * force_N) + " uN";
}

}  // namespace palpate
