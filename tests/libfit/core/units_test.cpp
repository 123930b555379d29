#include "libfit/core/units.hpp"

#include <gtest/gtest.h>

#include "tests/support/surfaces.hpp"

namespace palpate {
namespace {

TEST(units, a_number_with_its_unit_becomes_si) {
  EXPECT_DOUBLE_EQ(parse_quantity("12 mm", Dimension::length).value(), 0.012);
  EXPECT_DOUBLE_EQ(parse_quantity(" +1.5e1cm ", Dimension::length).value(), 0.15);
  EXPECT_DOUBLE_EQ(parse_quantity("-2 mm", Dimension::length).value(), -0.002);
  EXPECT_DOUBLE_EQ(parse_quantity("5 kPa", Dimension::pressure).value(), 5000);
  EXPECT_DOUBLE_EQ(parse_quantity("3 mN", Dimension::force).value(), 3e-3);
}

TEST(units, anything_else_is_refused) {
  for (const char* text : {"", " ", "mm", "12", "12 kPa", "12 furlongs", "12 mm mm", "nan mm",
                           "inf mm", "1e999 mm", "12,5 mm", "0x10 mm"})
    EXPECT_FALSE(parse_quantity(text, Dimension::length)) << text;
}

TEST(units, remedy_lists_every_unit_of_the_dimension) {
  EXPECT_EQ(known_units(Dimension::length), "m, dm, cm, mm, um, nm, in");
}

TEST(units, places_beside_the_body_are_told_by_the_unit_that_they_would_lie_in) {
  const Surface block = testing_support::coarse_block(0.08, 0.08, 0.03);
  const auto unit_of = [&](double x, double y, double z) {
    Points place(1, 3);
    place << x, y, z;
    return misread_unit(place, block).value_or("");
  };
  EXPECT_EQ(unit_of(40, 40, 30.5), "mm");
  EXPECT_EQ(unit_of(4, 4, 3.05), "cm");
  EXPECT_EQ(unit_of(40000, 40000, 30500), "um");
  EXPECT_EQ(unit_of(0.04, 0.04, 0.03), "") << "at the body";
  EXPECT_EQ(unit_of(0.04, 0.04, 0.12), "") << "above it";
  EXPECT_EQ(unit_of(0.04, 0.04, 0.3), "") << "beside it, and not a unit off";
  EXPECT_EQ(unit_of(1e9, 0, 0), "") << "nowhere";
  Points path(2, 3);
  path << 0.04, 0.04, 0.05, 40, 40, 30;
  EXPECT_FALSE(misread_unit(path, block)) << "a path that comes by";
}

TEST(units, a_length_of_ten_bodies_is_told_by_its_unit) {
  const Vec3 extent(0.08, 0.08, 0.03);
  EXPECT_EQ(misread_unit(8, extent), "mm");
  EXPECT_EQ(misread_unit(8000, extent), "um");
  EXPECT_FALSE(misread_unit(0.5, extent));
}

}  // namespace
}  // namespace palpate
