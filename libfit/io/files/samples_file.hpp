#pragma once

#include <filesystem>

#include "libfit/core/samples.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

/// Experiments of a samples.h5 (docs/formats.md), simulated, measured or made by others.
/// Throws Error on anything the contract does not allow: see the page. force and torque may be NaN
/// in rows whose status is not `good`, force_error anywhere; all else is finite.
Samples read_samples(const std::filesystem::path& path);

/// Stores them, whole or not at all. Refuses what read_samples would refuse.
void write_samples(const std::filesystem::path& path, const Samples& samples,
                   const Attributes& attributes = {});

}  // namespace palpate
