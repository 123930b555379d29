#pragma once

#include <string>

#include "libfit/fit/experiments.hpp"

namespace palpate::fit {

/// What a point's curves depend on besides bases and family: its place, its usable rows with their
/// weights, what is unknown of its sensors, and the options that a point's own fit reads. 16 hex
/// digits; equal means the curves need no refit.
std::string rows_hash(const Samples& samples, Eigen::Index point, const PointData& data,
                      double length_m, const FitOptions& options);

}  // namespace palpate::fit
