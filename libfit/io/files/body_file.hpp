#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

/// The body of a body.h5 (docs/formats.md). Throws Error on missing or malformed columns,
/// indices out of range, numbers that are not finite, normals that are not unit vectors.
Body read_body(const std::filesystem::path& path);

/// Stores it, whole or not at all. Refuses what read_body would refuse.
void write_body(const std::filesystem::path& path, const Body& body,
                const Attributes& attributes = {});

}  // namespace palpate
