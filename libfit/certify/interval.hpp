#pragma once

#include <cmath>
#include <limits>

namespace palpate::certify {

/// A range of numbers. Operations round to nearest: a bound made of them is widened by
/// kRoundingSlack where it is used, which is 10^5 times what a few hundred operations lose.
/// Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), chapter 2.
struct Interval {
  double lo = 0, hi = 0;
  constexpr Interval() = default;
  constexpr Interval(double x) : lo(x), hi(x) {}  // NOLINT: numbers are intervals
  constexpr Interval(double from, double to) : lo(from), hi(to) {}
};
constexpr double kRoundingSlack = 1e-9;  ///< relative to the terms of a sum

/// The smaller and the larger of two numbers; none where one of them is none, which std::min and
/// std::max may drop: a bound that forgets it would certify.
constexpr double least_of(double x, double y) { return x < y || x != x ? x : y; }
constexpr double most_of(double x, double y) { return x > y || x != x ? x : y; }

inline Interval operator-(const Interval& x) { return {-x.hi, -x.lo}; }
inline Interval operator+(const Interval& x, const Interval& y) {
  return {x.lo + y.lo, x.hi + y.hi};
}
inline Interval operator-(const Interval& x, const Interval& y) {
  return {x.lo - y.hi, x.hi - y.lo};
}
inline Interval operator*(const Interval& x, const Interval& y) {
  const double a = x.lo * y.lo, b = x.lo * y.hi, c = x.hi * y.lo, d = x.hi * y.hi;
  return {least_of(least_of(a, b), least_of(c, d)), most_of(most_of(a, b), most_of(c, d))};
}
inline Interval operator+(const Interval& x, double y) { return {x.lo + y, x.hi + y}; }
inline Interval operator-(const Interval& x, double y) { return {x.lo - y, x.hi - y}; }
inline Interval operator-(double x, const Interval& y) { return {x - y.hi, x - y.lo}; }
inline Interval operator*(const Interval& x, double y) {
  const double a = x.lo * y, b = x.hi * y;
  return {least_of(a, b), most_of(a, b)};
}
inline Interval operator/(const Interval& x, double y) { return x * (1 / y); }
/// Everything where y holds 0.
inline Interval operator/(const Interval& x, const Interval& y) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  if (y.lo <= 0 && y.hi >= 0) return {-kAll, kAll};
  return x * Interval(1 / y.hi, 1 / y.lo);
}
inline Interval sqrt(const Interval& x) {
  return {std::sqrt(most_of(x.lo, 0)), std::sqrt(most_of(x.hi, 0))};
}
inline Interval square(const Interval& x) {
  const double a = x.lo * x.lo, b = x.hi * x.hi;
  return {x.lo <= 0 && x.hi >= 0 ? 0 : least_of(a, b), most_of(a, b)};
}
inline Interval hull(const Interval& x, const Interval& y) {
  return {least_of(x.lo, y.lo), most_of(x.hi, y.hi)};
}
inline Interval not_negative(const Interval& x) { return {most_of(x.lo, 0), most_of(x.hi, 0)}; }
inline double lower(const Interval& x) { return x.lo; }
inline double upper(const Interval& x) { return x.hi; }
inline double size_of(const Interval& x) { return most_of(std::fabs(x.lo), std::fabs(x.hi)); }

inline double square(double x) { return x * x; }
inline double not_negative(double x) { return most_of(x, 0); }
inline double lower(double x) { return x; }
inline double upper(double x) { return x; }
inline double size_of(double x) { return std::fabs(x); }

}  // namespace palpate::certify
