#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// A test whose specimen deforms alike everywhere (M45): the machine sets some stretches, and
/// unloaded sides have the others.
struct HomogeneousTestRow {
  std::string_view name, summary;
  /// One letter for each diagonal entry of F: 'l' the stretch that is set, '1' held, 'f' free. In
  /// simple shear F = 1 + strain e1 e2.
  std::string_view sides;
  bool is_shear = false;
};

inline constexpr HomogeneousTestRow kHomogeneousTests[] = {
    {"uniaxial", "tension or compression along one axis, sides free", "lff"},
    {"equibiaxial", "two axes alike, thickness free", "llf"},
    {"planar", "wide sheet: one axis, width held (pure shear), thickness free", "l1f"},
    {"simple-shear", "faces held parallel and at their distance", "111", true},
};

/// One such test, N rows. stretch: of the axis (in simple shear the amount of shear). stress [Pa]:
/// force over area at rest, or where is_true over area now. deviation [Pa]: of a reading; NaN where
/// not stated.
struct HomogeneousTest {
  const HomogeneousTestRow* row = nullptr;
  Eigen::VectorXd stretch, stress;
  bool is_true = false;
  double deviation = std::numeric_limits<double>::quiet_NaN();
};

/// Stresses of the test by a material, free sides solved; empty where a state has no solution.
Eigen::VectorXd stresses(const Material& material, const HomogeneousTest& test);

/// The same of all tests, one after the other.
Eigen::VectorXd stresses(const MaterialParameters& material,
                         const std::vector<HomogeneousTest>& tests);

/// At most `rows` rows of a test, evenly.
HomogeneousTest thinned(const HomogeneousTest& test, Eigen::Index rows);

}  // namespace palpate::fem
