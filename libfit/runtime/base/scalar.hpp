// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Scalars of the law: 3-vectors of any scalar, a value with one derivative, and
// access to the plain number inside a scalar.

#include <cmath>

#include "rounding.hpp"

namespace palpate::runtime {

/// The plain number that decides branches. Scalars with a member `a` (Dual below, ceres::Jet) are
/// served here; any other gets an overload in its own namespace.
inline double value_of(double x) noexcept { return x; }
template <class J>
auto value_of(const J& x) noexcept -> decltype(double(x.a)) {
  return x.a;
}

/// A number and its derivative along one parameter: exact slopes for the engine's Newton steps.
/// The value part rounds exactly as the same expression in double does.
struct Dual {
  double a;  ///< value
  double v;  ///< derivative
  Dual() noexcept : a(0), v(0) {}
  explicit Dual(double value, double derivative = 0) noexcept : a(value), v(derivative) {}
};
inline Dual operator-(const Dual& x) noexcept { return Dual(-x.a, -x.v); }
inline Dual operator+(const Dual& x, const Dual& y) noexcept { return Dual(x.a + y.a, x.v + y.v); }
inline Dual operator-(const Dual& x, const Dual& y) noexcept { return Dual(x.a - y.a, x.v - y.v); }
inline Dual operator*(const Dual& x, const Dual& y) noexcept {
  return Dual(x.a * y.a, x.v * y.a + x.a * y.v);
}
inline Dual operator/(const Dual& x, const Dual& y) noexcept {
  const double q = x.a / y.a;
  return Dual(q, (x.v - q * y.v) / y.a);
}
inline Dual operator+(const Dual& x, double y) noexcept { return Dual(x.a + y, x.v); }
inline Dual operator-(const Dual& x, double y) noexcept { return Dual(x.a - y, x.v); }
inline Dual operator*(const Dual& x, double y) noexcept { return Dual(x.a * y, x.v * y); }
inline Dual operator/(const Dual& x, double y) noexcept { return Dual(x.a / y, x.v / y); }
inline Dual operator+(double x, const Dual& y) noexcept { return Dual(x + y.a, y.v); }
inline Dual operator-(double x, const Dual& y) noexcept { return Dual(x - y.a, -y.v); }
inline Dual operator*(double x, const Dual& y) noexcept { return Dual(x * y.a, x * y.v); }
inline Dual operator/(double x, const Dual& y) noexcept { return Dual(x) / y; }
/// The argument is > 0.
inline Dual sqrt(const Dual& x) noexcept {
  const double root = std::sqrt(x.a);
  return Dual(root, x.v / (2 * root));
}

/// A number and its derivatives along x, y and z: tangent.hpp's scalar.
struct Jet3 {
  double a;     ///< value
  double v[3];  ///< derivatives
  Jet3() noexcept : a(0), v{0, 0, 0} {}
  explicit Jet3(double value) noexcept : a(value), v{0, 0, 0} {}
  Jet3(double value, double vx, double vy, double vz) noexcept : a(value), v{vx, vy, vz} {}
  /// value with derivatives p times those of x plus q times those of y.
  static Jet3 chain(double value, double p, const Jet3& x, double q, const Jet3& y) noexcept {
    return Jet3(value, p * x.v[0] + q * y.v[0], p * x.v[1] + q * y.v[1], p * x.v[2] + q * y.v[2]);
  }
};
inline Jet3 operator-(const Jet3& x) noexcept { return Jet3::chain(-x.a, -1, x, 0, x); }
inline Jet3 operator+(const Jet3& x, const Jet3& y) noexcept {
  return Jet3::chain(x.a + y.a, 1, x, 1, y);
}
inline Jet3 operator-(const Jet3& x, const Jet3& y) noexcept {
  return Jet3::chain(x.a - y.a, 1, x, -1, y);
}
inline Jet3 operator*(const Jet3& x, const Jet3& y) noexcept {
  return Jet3::chain(x.a * y.a, y.a, x, x.a, y);
}
inline Jet3 operator/(const Jet3& x, const Jet3& y) noexcept {
  const double q = x.a / y.a;
  return Jet3::chain(q, 1 / y.a, x, -q / y.a, y);
}
inline Jet3 operator+(const Jet3& x, double y) noexcept { return Jet3::chain(x.a + y, 1, x, 0, x); }
inline Jet3 operator-(const Jet3& x, double y) noexcept { return Jet3::chain(x.a - y, 1, x, 0, x); }
inline Jet3 operator*(const Jet3& x, double y) noexcept { return Jet3::chain(x.a * y, y, x, 0, x); }
inline Jet3 operator/(const Jet3& x, double y) noexcept {
  return Jet3::chain(x.a / y, 1 / y, x, 0, x);
}
inline Jet3 operator+(double x, const Jet3& y) noexcept { return y + x; }
inline Jet3 operator-(double x, const Jet3& y) noexcept {
  return Jet3::chain(x - y.a, -1, y, 0, y);
}
inline Jet3 operator*(double x, const Jet3& y) noexcept { return y * x; }
inline Jet3 operator/(double x, const Jet3& y) noexcept { return Jet3(x) / y; }
/// The argument is > 0.
inline Jet3 sqrt(const Jet3& x) noexcept {
  const double root = std::sqrt(x.a);
  return Jet3::chain(root, 1 / (2 * root), x, 0, x);
}

/// A point, vector or force; units belong to the name it is given.
template <class T>
struct Vec3 {
  T x, y, z;
};
using Vec3d = Vec3<double>;

template <class T>
Vec3<T> make_vec3(const double* xyz) noexcept {
  return {T(xyz[0]), T(xyz[1]), T(xyz[2])};
}
inline void put(const Vec3d& from, double to[3]) noexcept {
  to[0] = from.x;
  to[1] = from.y;
  to[2] = from.z;
}
template <class T>
Vec3<T> operator+(const Vec3<T>& p, const Vec3<T>& q) noexcept {
  return {p.x + q.x, p.y + q.y, p.z + q.z};
}
template <class T>
Vec3<T> operator-(const Vec3<T>& p, const Vec3<T>& q) noexcept {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}
template <class T, class S>
auto operator*(const Vec3<T>& p, const S& s) noexcept -> Vec3<decltype(p.x * s)> {
  return {p.x * s, p.y * s, p.z * s};
}
template <class T, class S>
auto dot(const Vec3<T>& p, const Vec3<S>& q) noexcept -> decltype(p.x * q.x) {
  return p.x * q.x + p.y * q.y + p.z * q.z;
}
template <class T>
Vec3<T> cross(const Vec3<T>& p, const Vec3<T>& q) noexcept {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
/// Unit vector along p. The length of p is > 0: callers have checked their data.
template <class T>
Vec3<T> normalized(const Vec3<T>& p) noexcept {
  using std::sqrt;
  return p * (1.0 / sqrt(dot(p, p)));
}
/// Part of v across a unit normal.
template <class T>
Vec3<T> tangential(const Vec3<T>& v, const Vec3<T>& normal) noexcept {
  return v - normal * dot(v, normal);
}
template <class T>
Vec3d values_of(const Vec3<T>& p) noexcept {
  return {value_of(p.x), value_of(p.y), value_of(p.z)};
}
template <class T>
Vec3<T> widened(const Vec3d& p) noexcept {
  return {T(p.x), T(p.y), T(p.z)};
}
inline bool is_finite(const Vec3d& p) noexcept {
  return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
}

}  // namespace palpate::runtime
