#pragma once

// What several tests of refinement ask of a model.

#include <gtest/gtest.h>

#include "libfit/refine/refine.hpp"
#include "tests/libfit/refine/surfaces.hpp"

namespace palpate::testing_refine {

inline const Triangles kNone(0, 3);
inline const Field kSmooth = [](const Vec3& p) {
  return 3 + std::sin(60 * p.x()) + 0.5 * std::cos(50 * p.y() + 1) + 40 * p.z() * p.x();
};

/// z = (x^2 - y^2) / (2 R) over a square of 60 mm, R = 40 mm.
inline Surface saddle(int cells) {
  return sheet(cells, cells, [](double u, double v) {
    const double x = 0.06 * (u - 0.5), y = 0.06 * (v - 0.5);
    return Vec3(x, y, (x * x - y * y) / 0.08);
  });
}

/// Root mean square and largest error of the first normal control value over covered vertices.
struct FieldError {
  double rms = 0, most = 0;
  int covered = 0;
};
inline FieldError field_error(const Model& model, const Field& field) {
  FieldError error;
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    if (!model.is_covered[static_cast<std::size_t>(v)]) continue;
    const double e = std::abs(model.curves.control[0](v, 1) - field(model.surface.vertices.row(v)));
    error.rms += e * e;
    error.most = std::max(error.most, e);
    ++error.covered;
  }
  error.rms = std::sqrt(error.rms / error.covered);
  return error;
}

inline void expect_partition_of_unity(const Model& model) {
  for (Eigen::Index v = 0; v < model.blend_weight.rows(); ++v) {
    EXPECT_GE(model.blend_weight.row(v).minCoeff(), 0) << "vertex " << v;
    const double sum = model.is_covered[static_cast<std::size_t>(v)] ? 1 : 0;
    EXPECT_NEAR(model.blend_weight.row(v).sum(), sum, 1e-14) << "vertex " << v;
  }
}

}  // namespace palpate::testing_refine
