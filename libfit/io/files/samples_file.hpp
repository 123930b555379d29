#pragma once

#include <filesystem>
#include <optional>

#include "libfit/core/row_index.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

/// Experiments of a samples.h5 (docs/formats.md), simulated, measured or made by others.
/// Throws Error on anything the contract does not allow: see the page. force and torque may be NaN
/// in rows whose status is not `good`, force_error anywhere; all else is finite.
Samples read_samples(const std::filesystem::path& path);

/// The test points of a samples.h5 and what it says of the rows of each, which stay unread.
struct IndexedSamples {
  Samples points;        ///< without rows
  RowIndex index;        ///< of the rows in the file
  std::size_t rows = 0;  ///< in the file
};

/// Nothing where the file has no such index, or where rows have been changed since it was written:
/// the stored bytes of the rows are hashed, not unpacked. Throws Error on damaged test points.
std::optional<IndexedSamples> read_samples_index(const std::filesystem::path& path);

/// All test points, and the rows of those wanted alone, checked as read_samples does. Without
/// recordings. is_wanted: P.
Samples read_samples_of(const std::filesystem::path& path, const IndexedSamples& indexed,
                        const std::vector<char>& is_wanted);

/// Stores them, whole or not at all. Refuses what read_samples would refuse.
void write_samples(const std::filesystem::path& path, const Samples& samples,
                   const Attributes& attributes = {});

}  // namespace palpate
