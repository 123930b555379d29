#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "libfem/solve/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene.hpp"

namespace palpate::tools {

/// The simulator of a scene's body, material, inclusions and probe.
fem::Simulator make_simulator(const Scene& scene, const Body& body);

/// The probe with its mesh read. Throws Error as read_surface does.
fem::ProbeSpec probe_spec(const ProbeSection& section);
fem::SimulationSetup make_setup(const Scene& scene, const Body& body);
fem::Experiments experiments_of(const Scene& scene);

struct SimulateRequest {
  int jobs = 0;
  std::filesystem::path output;  ///< samples.h5; what is done is kept beside it until all is
  std::string inputs;            ///< hash that a kept part must carry to be resumed
  bool resume = true;
};

/// Presses and drags at every test point of the body, in parallel. What is done is kept in
/// `OUTPUT.partial`, rewritten at most every few seconds; an interruption (exception Interrupted)
/// leaves it there, and a later request with `resume` and the same inputs goes on from it.
Samples simulate_body(const Scene& scene, const Body& body, const SimulateRequest& request);

/// Deletes what an unfinished simulate kept.
void remove_partial(const std::filesystem::path& output);

/// Lists experiments with rows that are not good, at most a screenful. Returns how many there are.
std::size_t list_bad_experiments(const Samples& samples);

}  // namespace palpate::tools
