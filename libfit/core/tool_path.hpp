#pragma once

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Where a tool goes: successive deflections (N x 3 [m]) from first touch at a test point.
struct ToolPath {
  int point = 0;
  Points deflections;
};

}  // namespace palpate
