#pragma once

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"

namespace palpate {

/// Samples at the wanted points: the rows `from` has at the very same positions and normals (equal
/// bits), renumbered to their order; a point that `from` does not have gets no row, of one that it
/// has twice the first with rows counts. Experiments are numbered per_point * point + their number
/// within it, as simulated samples are. `from` must be numbered so itself. Recordings are left out.
/// is_dragged: of each wanted point, whether it must have drags or none; empty: either will do.
Samples take_points(const Samples& from, const TestPoints& wanted, int per_point,
                    const std::vector<char>& is_dragged = {});

/// Points and rows of both, those of `first` in front; experiment numbers likewise. per_point as
/// above. Points of both come twice.
Samples joined(const Samples& first, const Samples& second, int per_point);

/// Indices of points that have no row, ascending.
std::vector<std::int32_t> points_without_rows(const Samples& samples);

/// The samples at places with rows that are not among `points`, as above.
Samples samples_beyond(const Samples& samples, const TestPoints& points, int per_point,
                       const std::vector<char>& is_dragged = {});

}  // namespace palpate
