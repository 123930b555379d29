#pragma once

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"

namespace palpate::tools {

/// Curves on every fine node of the body's surface, with the probe of the curves; coverage is said
/// on stderr.
Model refine_body(const FittedCurves& curves, const Body& body);

}  // namespace palpate::tools
