#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/io/files/columns.hpp"

// What smoothing left in curves.h5 (docs/formats.md); for this layer alone.

namespace palpate::h5 {

/// Attributes `smoothing` (a number, as text) and `smoothing_reason` of each curves/KIND, and where
/// the number is above 0 the columns own_controls (N) and own_covariance (N^2). All may be absent.
/// read: into `curves`, whose bases and covariance were read before.
void read_smoothing(const Reader& reader, FittedCurves& curves);
void write_smoothing(Writer& writer, const FittedCurves& curves);

/// Strengths are finite and not negative; own curves are there exactly where one is above 0, are
/// admissible and as large as those smoothed.
void check_smoothing(const Complain& complain, const FittedCurves& curves);

}  // namespace palpate::h5
