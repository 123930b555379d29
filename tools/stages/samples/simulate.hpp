#pragma once

#include <string>
#include <vector>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {

/// The simulator of a scene's body, material, inclusions and probe. It keeps how the surface moves
/// where the scene wants it; one of make_setup does not.
fem::Simulator make_simulator(const Scene& scene, const Body& body);

/// Columns of Samples::surface of a scene: 0 where its samples do not tell how the surface moves.
Eigen::Index surface_columns(const Scene& scene, const Body& body);

/// True if some material of the scene relaxes; if one softens where it was strained.
bool relaxes(const Scene& scene);
bool softens(const Scene& scene);

/// The Prony series of the body's contacts: the material's as it is felt through forces (M14c), by
/// presses at the first few test points of its samples. Empty of a body whose own material does not
/// relax.
Relaxation contact_relaxation(const Scene& scene, const Body& body, const Samples& samples);

/// Adds what later stages need to know of the simulators of a list: their probes, and the body's
/// Poisson's ratio.
void add_origin(Samples& samples, const fem::SimulatorOf& simulator, const ExperimentList& list);

/// Says what error the rows' own estimates leave at the points, and whether it is what was asked
/// for (ExperimentsSection::force_tolerance). Returns the points that miss it.
std::size_t say_force_errors(const Samples& samples, double wanted);

/// Lists experiments with rows that are not good, at most a screenful. Returns how many there are.
std::size_t list_bad_experiments(const Samples& samples);

}  // namespace palpate::tools
