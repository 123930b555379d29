#pragma once

#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

/// Forces of a press at first over those of slow motion: the median over points and
/// rows, one coarse mesh each way. 0 where no point tells. Points that fail are left out.
double force_at_first(const Simulator& simulator, const TestPoints& points,
                      const Experiments& experiments, const Progress& progress = {});

/// The Prony series of a contact with a half-space of a material whose shape relaxes and whose bulk
/// does not (M14c): a branch for each of the material's, weaker and slower. at_first: its shares
/// are scaled so that they sum to at_first - 1; 0: they are those of the half-space.
Relaxation relaxation_of_contact(const Material& material, double at_first = 0);

}  // namespace palpate::fem
