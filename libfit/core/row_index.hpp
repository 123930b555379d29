#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate {

/// Where the rows of each test point are and a fingerprint of them, so that who has fitted a point
/// knows without reading its rows that they are the same. P points.
struct RowIndex {
  std::vector<std::int32_t> first_row;         ///< P; 0 for a point without rows
  std::vector<std::int32_t> row_count;         ///< P
  std::vector<std::int32_t> first_experiment;  ///< P, of the point's first row; 0 without rows
  /// P, 16 hex digits: of the point's rows in order, all that a fit reads of them (kind, step,
  /// deflection, force, force_error, status, and where one experiment ends and how ids go on, not
  /// where they begin).
  std::vector<std::string> hash;
  bool is_contiguous = true;  ///< the rows of every point follow one another
};

/// Index of samples whose arrays belong together; points out of range are left out.
RowIndex index_rows(const Samples& samples);

}  // namespace palpate
