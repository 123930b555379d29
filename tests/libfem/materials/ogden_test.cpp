#include <gtest/gtest.h>

#include <cmath>

#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

using namespace examples;

// With exponents 2 and -2 the law is one of the invariants, which never see principal directions:
// equal and nearly equal stretches have no excuse.
void expect_same(const Material& ogden, const Material& invariants) {
  for (const Mat3& F : states()) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << " F\n" << F);
    const double W = invariants.law->evaluate(invariants.constants, F).W;
    const Mat3 P = invariants.law->evaluate(invariants.constants, F).P;
    const Mat9 A = invariants.law->evaluate(invariants.constants, F).A;
    EXPECT_NEAR(ogden.law->evaluate(ogden.constants, F).W, W, 1e-12 * W + 1e-28);
    EXPECT_LE((ogden.law->evaluate(ogden.constants, F).P - P).norm(), 1e-12 * P.norm());
    EXPECT_LE((ogden.law->evaluate(ogden.constants, F).A - A).norm(), 1e-12 * A.norm());
  }
}

TEST(Ogden, with_exponent_2_is_neo_hookean) {
  const SmallStrain hooke = [] {
    const Material m = make_material({"neo-hookean-isochoric", {1.0, 0.45}}, "test");
    return m.law->small_strain(m.constants);
  }();
  expect_same(
      make_material({"ogden", {hooke.mu_Pa, 2, kLeftOut, kLeftOut, kLeftOut, kLeftOut, 0.45}},
                    "test"),
      make_material({"neo-hookean-isochoric", {1.0, 0.45}}, "test"));
}

TEST(Ogden, with_exponents_2_and_minus_2_is_mooney_rivlin) {
  expect_same(
      make_material({"ogden", {2 * 0.12, 2, -2 * 0.05, -2, kLeftOut, kLeftOut, 0.45, 7}}, "test"),
      make_material({"mooney-rivlin", {0.12, 0.05, 0.45, 7}}, "test"));
}

TEST(Ogden, its_terms_may_come_in_any_order) {
  const Material a = make_material({"ogden", {0.63, 1.3, 0.0012, 5, -0.01, -2}}, "test");
  const Material b = make_material({"ogden", {-0.01, -2, 0.63, 1.3, 0.0012, 5}}, "test");
  for (const Mat3& F : states())
    EXPECT_LE((a.law->evaluate(a.constants, F).A - b.law->evaluate(b.constants, F).A).norm(),
              1e-13 * 50)
        << "F\n"
        << F;
}

}  // namespace
}  // namespace palpate::fem
