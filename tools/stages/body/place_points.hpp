#pragma once

#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/csv/tables.hpp"

namespace palpate::tools {

/// Points a user gave, moved to the nearest place of the surface. Normals are the surface's own
/// (interpolated, inward) unless the table has some. Named "p0001"...
/// Throws Error at `where` with the row of a point farther than 5 % of the body's diagonal: it is
/// another unit or another body.
TestPoints place_points(const PointTable& points, const Surface& surface, const std::string& where);

/// Throws Error where two rows of a table `where` are at one place.
void refuse_same_place(const Points& position, const std::string& where);

/// The same as place_points() for tool paths; deflections stay as they are. normal: inward, one row
/// per path.
struct PlacedPaths {
  TestPoints points;
  std::vector<ToolPath> paths;  ///< one per point
};
PlacedPaths place_paths(const std::vector<PathInTable>& paths, const Surface& surface,
                        const std::string& where);

}  // namespace palpate::tools
