// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Displacement of a body as a whole under a force (docs/method-body.md, section 21): a compliance
// C, and the root L of it by which contacts far from each other sway together (M62a).

#include <cmath>

#include "../base/scalar.hpp"

namespace palpate::runtime {

/// C [m/N], symmetric and nowhere negative: xx, yy, zz, xy, xz, yz.
struct Compliance {
  double c[6] = {0, 0, 0, 0, 0, 0};

  Vec3d times(const Vec3d& f) const noexcept {
    return {c[0] * f.x + c[3] * f.y + c[4] * f.z, c[3] * f.x + c[1] * f.y + c[5] * f.z,
            c[4] * f.x + c[5] * f.y + c[2] * f.z};
  }
  bool is_any() const noexcept {
    for (double x : c)
      if (x != 0) return true;
    return false;
  }
};

/// L with L L^T = C: lower triangular, xx, yx, yy, zx, zy, zz [sqrt(m/N)]; it is zero along rigid
/// directions.
struct ComplianceRoot {
  double l[6] = {0, 0, 0, 0, 0, 0};

  Vec3d times(const Vec3d& v) const noexcept {
    return {l[0] * v.x, l[1] * v.x + l[2] * v.y, l[3] * v.x + l[4] * v.y + l[5] * v.z};
  }
  Vec3d back_times(const Vec3d& v) const noexcept {
    return {l[0] * v.x + l[1] * v.y + l[3] * v.z, l[2] * v.y + l[4] * v.z, l[5] * v.z};
  }
};
/// Cholesky's factor.
inline ComplianceRoot root_of(const Compliance& compliance) noexcept {
  const double* c = compliance.c;
  const double least = 1e-12 * (c[0] + c[1] + c[2]);
  ComplianceRoot out;
  double* l = out.l;
  if (c[0] > least) {
    l[0] = std::sqrt(c[0]);
    l[1] = c[3] / l[0];
    l[3] = c[4] / l[0];
  }
  const double yy = c[1] - l[1] * l[1];
  if (yy > least) {
    l[2] = std::sqrt(yy);
    l[4] = (c[5] - l[3] * l[1]) / l[2];
  }
  const double zz = c[2] - l[3] * l[3] - l[4] * l[4];
  if (zz > least) l[5] = std::sqrt(zz);
  return out;
}

/// Returns true if the compliance is positive semidefinite, but for rounding to float.
inline bool is_positive_semidefinite(const double c[6]) noexcept {
  const double trace = c[0] + c[1] + c[2], slack = 1e-6 * trace;
  const double x = c[0] + slack, y = c[1] + slack, z = c[2] + slack;
  const double xy = x * y - c[3] * c[3], xz = x * z - c[4] * c[4], yz = y * z - c[5] * c[5];
  const double determinant =
      x * yz - c[3] * (c[3] * z - c[5] * c[4]) + c[4] * (c[3] * c[5] - y * c[4]);
  return x >= 0 && y >= 0 && z >= 0 && xy >= 0 && xz >= 0 && yz >= 0 && determinant >= 0;
}

}  // namespace palpate::runtime
