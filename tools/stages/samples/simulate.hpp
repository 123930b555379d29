#pragma once

#include <string>
#include <vector>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/csv/tables.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The simulator of a scene's body, material, inclusions and probe. It keeps how the surface moves
/// where the scene wants it; one of make_setup does not.
fem::Simulator make_simulator(const Scene& scene, const Body& body);
/// The same asked for another force error, relative; 0: as it comes.
fem::Simulator make_simulator(const Scene& scene, const Body& body, double force_tolerance);

/// A row of the surface's motion takes some 3 bytes a vertex; a finer surface is not kept.
inline constexpr Eigen::Index kMaxSurfaceVertices = 20000;
/// Whether a scene's samples tell how the surface moves.
bool keeps_surface(const Scene& scene, const Body& body);

/// Whether some material of the scene relaxes.
bool relaxes(const Scene& scene);

fem::SimulationSetup make_setup(const Scene& scene, const Body& body);
fem::Experiments experiments_of(const Scene& scene);

/// The Prony series of the body's contacts: the material's as it is felt through forces (M14c), by
/// presses at the first few test points of its samples. Empty of a body whose own material does not
/// relax.
Relaxation contact_relaxation(const Scene& scene, const Body& body, const Samples& samples);

/// Adds what later stages need to know of the simulator: its probe, and the body's Poisson's ratio.
void add_origin(Samples& samples, const fem::Simulator& simulator);

/// Says what error the rows' own estimates leave at the points, and whether it is what was asked
/// for (ExperimentsSection::force_tolerance). Returns the points that miss it.
std::size_t say_force_errors(const Samples& samples, double wanted);

/// Lists experiments with rows that are not good, at most a screenful. Returns how many there are.
std::size_t list_bad_experiments(const Samples& samples);

/// Points a user gave, moved to the nearest place of the surface. Normals are the surface's own
/// (interpolated, inward) unless the table has some. Named "p0001"...
/// Throws Error at `where` with the row of a point farther than 5 % of the body's diagonal: it is
/// another unit or another body.
TestPoints place_points(const PointTable& points, const Surface& surface, const std::string& where);

/// Throws Error where two rows of a table `where` are at one place.
void refuse_same_place(const Points& position, const std::string& where);

/// The same for tool paths; deflections stay as they are. normal: inward, one row per path.
struct PlacedPaths {
  TestPoints points;
  std::vector<ToolPath> paths;  ///< one per point
};
PlacedPaths place_paths(const std::vector<PathInTable>& paths, const Surface& surface,
                        const std::string& where);

}  // namespace palpate::tools
