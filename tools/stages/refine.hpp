#pragma once

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"

namespace palpate::tools {

/// Curves on every fine node of the body's surface; coverage is said on stderr. The probe's radius
/// comes from the scene that the body carries, 0 where it carries none.
Model refine_body(const FittedCurves& curves, const Body& body);

}  // namespace palpate::tools
