#pragma once

#include <string>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/scan/recording.hpp"

namespace palpate::scan {

/// Result of an identification. The rows of `curves` are the vertices of the surface.
struct ScanFit {
  Surface surface;
  FittedCurves curves;
  std::vector<char> is_covered;  ///< of vertices: curves from rows, not from the prior alone
  Recording recording;
  Eigen::VectorXd deviation;  ///< of its numbers; 0 of those that are not free
  /// Errors at half of the passes, and at the others, which chose the unknowns of the recording.
  RelativeErrors fitted, left_out;
  std::vector<std::string> notes;  ///< a sentence on each finding and on what the scan covers
};

/// Points on the surface under a scan, by a fit of all of it, # x 3 [m].
Points points_on_surface(const Samples& scans, int jobs, const Progress& progress);

/// Surface, curves and unknowns of the recording from rows of the kind `scan`, each experiment a
/// pass in its recording's time, and from presses and drags of the same rig, which have no bias
/// (docs/measured-data.md, Scans). known: the body's surface in the scan's frame [m], which the
/// result then has; curves are of its vertices, beyond the scan 0. jobs: threads, 0: all; the
/// result does not depend on it, and is none where Progress stopped it. Throws Error where nothing
/// presses, or no vertex of `known` lies under the rows.
ScanFit identify(const Samples& scans, int jobs = 0, const Progress& progress = {},
                 const Surface* known = nullptr);

/// The same scans without what belongs to their recordings: places of the tip at the time of the
/// force, forces on the body, each pass placed at the point of the surface under its first row.
Samples corrected(const Samples& scans, const Surface& surface, const Recording& recording);

/// Numbers of a later recording with the rig of an earlier one: its drift is not known, and the
/// bias is the mean reading of rows whose tip is clearance_m or more above the surface, where there
/// are ten or more of them. rows_in_air: their number.
Recording later_recording(const Samples& scans, const Surface& surface, const Recording& earlier,
                          double clearance_m, Eigen::Index* rows_in_air);

}  // namespace palpate::scan
