#pragma once

#include "tests/libfit/fit/synthetic.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate::test {

using testing_support::number_rows;

inline const std::filesystem::path kCaseCurves = testing_support::shared_data("cases/curves");

/// Piecewise linear through two columns in mm and N.
inline Curve through(const std::vector<std::vector<double>>& rows) {
  return [rows](double x_m) {
    const double x = x_m * 1e3;
    std::size_t i = 1;
    while (i + 1 < rows.size() && rows[i][0] < x) ++i;
    const double t = (x - rows[i - 1][0]) / (rows[i][0] - rows[i - 1][0]);
    return (1 - t) * rows[i - 1][1] + t * rows[i][1];
  };
}

}  // namespace palpate::test
