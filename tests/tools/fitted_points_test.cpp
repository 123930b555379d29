// Which law a fit takes, and which of its points are said to have failed.

#include <gtest/gtest.h>

#include "tools/stages/fit.hpp"

namespace palpate::tools {
namespace {

FittedCurves points_of(int good, int poor, int underdetermined) {
  FittedCurves curves;
  curves.status.insert(curves.status.end(), static_cast<std::size_t>(good), FitStatus::good);
  curves.status.insert(curves.status.end(), static_cast<std::size_t>(poor), FitStatus::poor);
  curves.status.insert(curves.status.end(), static_cast<std::size_t>(underdetermined),
                       FitStatus::underdetermined);
  curves.name.assign(curves.status.size(), "p");
  curves.message.assign(curves.status.size(), "residual is 12 % of the force");
  return curves;
}

// 28 of a spleen's 48 points were poor or underdetermined, with status 0.
TEST(fitted_points, a_quarter_of_them_poor_is_a_failure_and_is_said) {
  EXPECT_EQ(list_bad_points(points_of(48, 0, 0)), 0U);
  EXPECT_EQ(list_bad_points(points_of(37, 11, 0)), 0U);
  testing::internal::CaptureStderr();
  EXPECT_EQ(list_bad_points(points_of(36, 12, 0)), 12U);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(holds(said, "poor: p: residual is 12 % of the force"));
  EXPECT_TRUE(holds(said, "12 of 48 points are poor"));
  EXPECT_EQ(list_bad_points(points_of(20, 20, 8)), 28U);
  EXPECT_EQ(list_bad_points(points_of(47, 0, 1)), 1U) << "no curves of its own";
  EXPECT_EQ(list_bad_points(points_of(40, 0, 8), true), 0U) << "a quick run asked for few rows";
}

}  // namespace
}  // namespace palpate::tools
