#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/io/files/columns.hpp"

// The curve bases and control values that curves.h5 and model.h5 share; for this layer alone.

namespace palpate::h5 {

/// Curves under curves/normal, curves/lateral and curves/limit: knots (m), controls (N, a row per
/// point) and the attribute `degree`; of a leaning family likewise curves/lean, controls in m.
/// Throws Error when the root attribute `family` is unknown.
CurveSet read_curve_set(const Reader& reader, std::size_t points);
void write_curve_set(Writer& writer, const CurveSet& curves);

/// Bases can be tabulated; every row of controls has the basis's size, starts at 0, never falls
/// (but for the lean), is finite and held exactly by float32.
void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points);

/// The same of one kind's control values under `name`, of P = points rows and basis.size() columns.
void check_controls(const Complain& complain, const std::string& name, const Controls& controls,
                    const CurveBasis& basis, Eigen::Index points);

}  // namespace palpate::h5
