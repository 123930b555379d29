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

/// Writes the rows that are of no press from the coarse grid alone, times what the press's rows of
/// `out`, written before, have over those of the coarse grid (M13k). Their error is that of the
/// press (median) and what one factor for both leaves. All stays where the press has no such rows.
void record_by_press(const std::vector<PathRow>& coarse, std::vector<PointRow>& out);

/// Good rows of presses whose force stands more than 45 degrees off `normal`, along which they go
/// in, become `wedged`; what they hold stays. In a groove or beside a step the tool rests on a bank
/// before it reaches the place that it is pressed at: sound rows stand up to 30 degrees off, wedged
/// ones 57 to 71, and their stated errors do not hold. Drags and paths are left as they are, for a
/// force across is what they are made for.
void mark_wedged(const Vec3& normal, std::vector<PointRow>& rows);

}  // namespace palpate::fem
