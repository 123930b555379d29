#include <gtest/gtest.h>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {
namespace {

/// W, P and A : H of one deformation gradient, from 40-digit differences of W(F), for mu = 1/3 and
/// lambda = 3; matrices row major.
struct Reference {
  const char* name;
  double F[9], W, P[9], A_H[9];
};

constexpr double kDirection[9] = {0.3, -0.7, 0.2, 0.5, 0.1, -0.4, 0.6, -0.2, 0.8};  // H

constexpr Reference kReferences[] = {
    {"identity",
     {1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0},
     0,
     {0, 0, 0, 0, 0, 0, 0, 0, 0},
     {3.8, -0.0666666666666667, 0.266666666666667, -0.0666666666666667, 3.66666666666667, -0.2, 0.266666666666667, -0.2, 4.13333333333333}},
    {"uniax_1.5_iso",
     {1.5, 0, 0, 0, 0.8, 0, 0, 0, 0.8},
     0.104440317695003,
     {0.196133788737268, 0, 0, 0, -0.303082479450957, 0, 0, 0, -0.303082479450957},
     {2.81077324225255, -0.0434169512941255, 0.294566325113716, -0.0992162681882243, 5.07330197659804, -0.275770619862739, 0.275966552815683, -0.351541239725478, 5.80516581278429}},
    {"compress_0.6",
     {0.6, 0, 0, 0, 1.25, 0, 0, 0, 1.25},
     0.108594004778461,
     {-0.678248161243411, 0, 0, 0, -0.00489245073017081, 0, 0, 0, -0.00489245073017081},
     {6.63912408062171, 0.117965931164031, 0.488225784063504, -0.325152303629644, 2.99505806272508, -0.200782792116827, 0.340519705798946, -0.201565584233655, 3.46446450180064}},
    {"equibiax_1.3",
     {1.3, 0, 0, 0, 1.3, 0, 0, 0, 0.6},
     0.118988967768543,
     {0.209006704236134, 0, 0, 0, 0.209006704236134, 0, 0, 0, -0.286041029710598},
     {3.93874993215853, -0.147053860603641, 0.290993295763866, 0.0458754048450978, 3.83757147639998, -0.208108876365733, 0.2747755430324, -0.216217752731466, 9.11984957807567}},
    {"shear_0.5",
     {1.0, 0.5, 0, 0, 1.0, 0, 0, 0, 1.0},
     0.0416666666666667,
     {0, 0.166666666666667, 0, 0.166666666666667, 0, 0, 0, 0, 0},
     {2.96666666666667, -0.0666666666666667, 0.266666666666667, -1.51666666666667, 2.83333333333333, -0.3, 0.333333333333333, -0.2, 3.38333333333333}},
    {"vol_0.9",
     {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9},
     0.160221832163548,
     {-1.12397552694863, 0, 0, 0, -1.12397552694863, 0, 0, 0, -1.12397552694863},
     {5.01910295342732, 0.55776418163813, 1.01598368463242, -0.940869854293382, 4.63599728077207, -0.449772339321919, 0.516439005988585, -0.699544678643837, 5.97686713506545}},
    {"general",
     {1.1, 0.25, -0.15, 0.05, 0.85, 0.3, -0.2, 0.1, 1.2},
     0.0908159744123389,
     {0.139805071377747, 0.110831708519869, -0.0901017971470312, 0.0888499015313228, -0.0122741999219253, 0.136664500248714, -0.113070174793946, 0.110672513545465, 0.188606240753507},
     {4.03517340333262, -0.648244383694956, 0.901853213025808, -1.30917074159325, 5.11577786331615, -0.912645818682569, 1.15366304373611, -1.54382004088184, 4.06269182746639}},
};

using Mat3Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec9 = Eigen::Matrix<double, 9, 1>;

Material material_under_test() {
  // The constants are given, so that no digits are lost on the way through young and poisson.
  Material material = make_material({"neo-hookean", {1.0, 0.45}}, "test");
  material.constants = {1.0 / 3, 3.0};
  return material;
}

TEST(NeoHookeanValues, energy_stress_and_tangent_match_forty_digit_references) {
  const Material material = material_under_test();
  const Vec9 H = Eigen::Map<const Vec9>(kDirection);
  for (const Reference& reference : kReferences) {
    SCOPED_TRACE(reference.name);
    const Mat3 F = Eigen::Map<const Mat3Rows>(reference.F);
    const Mat3 P = Eigen::Map<const Mat3Rows>(reference.P);
    const Vec9 A_H = Eigen::Map<const Vec9>(reference.A_H);
    EXPECT_NEAR(material.law->energy(material.constants, F), reference.W,
                1e-10 * std::max(reference.W, 1e-3));
    EXPECT_LE((material.law->stress(material.constants, F) - P).norm(), 1e-10 * P.norm() + 1e-15);
    EXPECT_LE((material.law->tangent(material.constants, F) * H - A_H).norm(), 1e-8 * A_H.norm());
  }
}

TEST(NeoHookeanValues, young_and_poisson_give_back_the_lame_constants) {
  const SmallStrain wanted{1.0 / 3, 3.0};
  const Material material =
      make_material({"neo-hookean", {wanted.young_Pa(), wanted.poisson()}}, "test");
  EXPECT_NEAR(material.constants[0], wanted.mu_Pa, 1e-13);
  EXPECT_NEAR(material.constants[1], wanted.lambda_Pa, 1e-12);
}

}  // namespace
}  // namespace palpate::fem
