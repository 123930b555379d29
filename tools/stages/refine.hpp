#pragma once

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/refine/refine.hpp"

namespace palpate::tools {

/// Curves on every fine node of the body's surface, with the probe of the curves; coverage is said
/// on stderr.
Model refine_body(const FittedCurves& curves, const Body& body, const RefineOptions& options = {});

/// RefineOptions::slope_share from text: auto or a number.
std::optional<double> slope_share_choice(const std::string& text);

}  // namespace palpate::tools
