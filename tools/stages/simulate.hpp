#pragma once

#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/sample_cache.hpp"

namespace palpate::tools {

/// The simulator of a scene's body, material, inclusions and probe.
fem::Simulator make_simulator(const Scene& scene, const Body& body);
/// The same asked for another force error, relative; 0: as it comes.
fem::Simulator make_simulator(const Scene& scene, const Body& body, double force_tolerance);

fem::SimulationSetup make_setup(const Scene& scene, const Body& body);
fem::Experiments experiments_of(const Scene& scene);

/// Presses and drags at every test point of the body (SampleCache::at).
Samples simulate_body(const Scene& scene, const Body& body, const SimulateRequest& request);

/// Adds what later stages need to know of the simulator: its probe, and the body's Poisson's ratio.
void add_origin(Samples& samples, const fem::Simulator& simulator);

/// Says what error the rows' own estimates leave at the points, and whether it is what was asked
/// for (ExperimentsSection::force_tolerance). Returns the points that miss it.
std::size_t say_force_errors(const Samples& samples, double wanted);

/// Lists experiments with rows that are not good, at most a screenful. Returns how many there are.
std::size_t list_bad_experiments(const Samples& samples);

}  // namespace palpate::tools
