#pragma once

#include <vector>

#include "libfem/solve/equilibrium/path_follower.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

/// Writes forces, torques, errors and statuses of `out` [N rows, experiment after experiment] from
/// what was solved on two meshes, the coarse one `ratio` times as coarse: extrapolated experiment
/// by experiment, with the error (M13b), (M13c), of which min_error is the least share. coarse:
/// empty where there is one mesh.
void record_rows(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse, double ratio,
                 double min_error, std::vector<PointRow>& out);

}  // namespace palpate::fem
