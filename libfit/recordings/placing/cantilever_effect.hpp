#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/placing/place.hpp"

namespace palpate::recordings {

/// How an apparent modulus changes with what the manifest says of the cantilever, as powers: 1 %
/// more stiffness makes it `stiffness` % larger.
struct CantileverEffect {
  double stiffness = 0, sensitivity = 0;
  double max_sensitivity_m = 0;  ///< on a rigid body the steepest third would show this one
};

/// Of one recording, from its rows: F = k s V and depth = scanner - s V, so E ~ F / depth^p goes
/// as k s^(1 + p bend / depth); where the file states the force, as k^(-p bend / depth). Nothing
/// without a cantilever or a good row.
std::optional<CantileverEffect> cantilever_effect(const BatchItem& item, const Conditioned& r);

/// A sentence about all imported recordings that use one: what it was taken to be, what 10 % of it
/// does to the moduli (medians), and what the stated deviations leave open. Empty when none does.
std::vector<std::string> cantilever_notes(const std::vector<BatchItem>& items,
                                          const std::vector<Candidate>& candidates);

}  // namespace palpate::recordings
