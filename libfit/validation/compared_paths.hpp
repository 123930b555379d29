#pragma once

#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/validation/follow.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// A reference row that worked out. path and step number the held-out paths and their rows.
struct PathRow {
  std::size_t path = 0;
  Eigen::Index step = 0;
  Vec3 force_N = Vec3::Zero();  ///< on the body
  double error_N = 0;           ///< the reference's own estimate
};

/// The good rows of simulated paths.
std::vector<PathRow> good_rows(const Samples& paths);

/// What an engine answered at a row.
inline Vec3 force_at(const std::vector<Followed>& followed, const PathRow& at) {
  return followed[at.path].force.row(at.step);
}

/// Good rows with an engine's answers.
std::vector<ComparedRow> compared_rows(const Samples& paths, const std::vector<Followed>& followed);

}  // namespace palpate::validation
