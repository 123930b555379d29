#pragma once

#include "libfit/core/measured.hpp"
#include "libfit/io/files/columns.hpp"

// The optional group `recordings` of samples.h5; for this layer alone.

namespace palpate::h5 {

/// Empty when the file has no such group.
MeasuredRecordings read_measured(const Reader& reader);
/// Writes nothing for simulated samples.
void write_measured(Writer& writer, const MeasuredRecordings& recordings);
/// Columns of one length; contact and its deviation finite.
void check_measured(const MeasuredRecordings& recordings, const Complain& complain);

}  // namespace palpate::h5
