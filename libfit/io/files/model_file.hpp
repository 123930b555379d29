#pragma once

#include <filesystem>

#include "libfit/core/curves.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

/// The refined model of a model.h5 (docs/formats.md). Throws Error on missing or malformed columns,
/// indices out of range, curves that fall or are not exact in float32, weights that are negative or
/// do not sum to 1 (0 where not covered) within 1e-12, a probe that is none (probe_group.hpp).
Model read_model(const std::filesystem::path& path);

/// Stores it, whole or not at all. Refuses what read_model would refuse.
void write_model(const std::filesystem::path& path, const Model& model,
                 const Attributes& attributes = {});

}  // namespace palpate
