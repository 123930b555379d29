#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/io/files/columns.hpp"

// The curve bases and control values that curves.h5 and model.h5 share; for this layer alone.

namespace palpate::h5 {

/// The parts of the family that the root attribute `family` names, each under curves/NAME: controls
/// (in the part's unit, a row per point) and, of a curve, knots (m) and the attribute `degree`.
/// Throws Error when the family is unknown.
CurveSet read_curve_set(const Reader& reader, std::size_t points);
void write_curve_set(Writer& writer, const CurveSet& curves);

/// Bases can be tabulated; every row of a part has the basis's size, is finite, held exactly by
/// float32, within the part's bounds, starts at 0 and never falls where the part says so.
void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points);

/// The same of one part's numbers under `name`, of P = points rows.
void check_controls(const Complain& complain, const std::string& name, const runtime::Part& part,
                    const Controls& controls, const CurveBasis& basis, Eigen::Index points);

}  // namespace palpate::h5
