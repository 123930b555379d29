#pragma once

#include "libfit/core/stated_error.hpp"
#include "libfit/fit/point/replay.hpp"

namespace palpate::fit {

/// Control values as an asset stores them: representable in float32, b_0 = 0, never falling, and
/// strictly rising when asked. increments: times force_N [N].
Eigen::VectorXd stored_controls(const Eigen::VectorXd& increments, double force_N,
                                bool is_strictly_rising);

/// Numbers of a part as an asset stores them: exact in float32, within the part's bounds. unknowns:
/// as part_controls wants them, in units of length_m and the point's force.
Eigen::VectorXd stored_part(const runtime::Part& part, const PointData& point,
                            const Eigen::VectorXd& unknowns, double length_m);

/// Force differences of a point, replayed by the engine's template in SI from stored controls.
/// controls: of each part. sensor: of each experiment in SI,
/// taken off its rows; empty for none.
struct PointScore {
  double rms_N = 0, max_N = 0;
  double relative = 0;                ///< rms difference over rms force
  std::vector<ForceError> rows;       ///< of each
  int slipped_rows = 0;               ///< replayed as slipping
  std::int32_t worst_experiment = 0;  ///< id, with the row in it
  std::size_t worst_row = 0;
};
PointScore score_point(const Samples& samples, const PointData& point, double length_m,
                       const Bases& bases_m, const std::vector<Eigen::VectorXd>& controls,
                       const std::vector<NuisanceValues>& nuisance = {});

}  // namespace palpate::fit
