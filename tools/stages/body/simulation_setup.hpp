#pragma once

#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What the simulator is told of a scene: body, material, inclusions, beds and probe.
fem::SimulationSetup make_setup(const Scene& scene, const Body& body);

/// The presses and drags that the scene makes at each of its test points.
fem::Experiments experiments_of(const Scene& scene);

}  // namespace palpate::tools
