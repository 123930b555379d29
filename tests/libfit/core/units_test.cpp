#include "libfit/core/units.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace palpate
