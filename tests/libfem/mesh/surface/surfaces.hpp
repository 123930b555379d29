#pragma once

#include "tests/support/surfaces.hpp"

// Surfaces of known shape, for the tests of points and fill.

namespace palpate::testing {

using testing_support::cube;
using testing_support::inside_out;
using testing_support::moved;
using testing_support::subdivided;
using testing_support::together;

inline Surface sphere(double radius_m, int levels) {
  return testing_support::octasphere(levels, radius_m);
}

}  // namespace palpate::testing
