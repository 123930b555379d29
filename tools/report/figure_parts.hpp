#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tools/report/packed.hpp"
#include "tools/report/svg_plot.hpp"

namespace palpate::tools {

// What the figures of a report have in common. contents: docs/formats/report.md, "Contents of a
// report".

/// Force over deflection at three test points: presses, and drags.
std::string curves_svg(const Json& contents);
/// The body seen along the mean normal of its test points, coloured by normal stiffness.
std::string stiffness_svg(const Json& contents);

using Numbers = std::vector<double>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

inline constexpr double kWidth_pt = 482;  // 170 mm: two columns

inline Numbers numbers(const Json& json) {
  const auto values = unpacked<float>(json);
  return {values.begin(), values.end()};
}
inline Rows rows(const Json& json) {
  const Numbers values = numbers(json);
  return Eigen::Map<const Rows>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3);
}
/// Newtons as a figure shows them.
struct ForceUnit {
  explicit ForceUnit(double most_N) : factor(most_N < 1 ? 1e3 : 1), name(most_N < 1 ? "mN" : "N") {}
  double factor;
  const char* name;
};

inline double most(const Numbers& values) {
  double out = 0;
  for (const double v : values)
    if (std::isfinite(v)) out = std::max(out, v);
  return out;
}

}  // namespace palpate::tools
