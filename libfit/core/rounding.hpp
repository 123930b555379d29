#pragma once

#include <Eigen/Core>

namespace palpate {

/// The nearest float, as a double. Through memory: g++ 12.2 at -O3 drops the two casts for some
/// vectors of fixed size (`.cast<float>().cast<double>()`), and what is written as float then
/// differs from what was scored.
inline double rounded_to_float(double value) {
  const volatile float rounded = static_cast<float>(value);
  return static_cast<double>(rounded);
}

/// The same for each entry of a matrix of doubles.
template <class Derived>
typename Derived::PlainObject rounded_to_float(const Eigen::MatrixBase<Derived>& values) {
  return values.unaryExpr([](double value) { return rounded_to_float(value); });
}

}  // namespace palpate
