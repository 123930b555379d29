#pragma once

#include <Eigen/Dense>
#include <optional>

#include "libfit/core/curves.hpp"

namespace palpate {

/// Changes of a model that need no new experiment.
struct ModelChanges {
  double stiffness = 1;                 ///< factor on all moduli of the body
  std::optional<double> friction = {};  ///< Coulomb's coefficient of the interface, 0 to 10
};

/// Multiplies what is a force and divides what is a compliance: the answer of a body whose moduli
/// are all larger by the factor, which is exact. Friction limits go with the coefficient, which is
/// nearly so (docs/after-a-run.md). Numbers are rounded to float32, as a fit rounds them.
/// Throws Error where a number leaves the bounds of its part, or the model's friction is not known.
void change_model(Model& model, const ModelChanges& changes);

/// Factor on a model's forces that recorded ones ask for.
struct StiffnessFit {
  double factor = 1;
  double deviation = 0;  ///< its standard error
  double misfit = 0;     ///< rms of the recorded forces less the scaled ones, over their own rms
};

/// min over s of sum (F - s f)^2, f the answers and F the recorded forces [N], as many. Throws
/// Error where there are fewer than two, or no answer is above 0.
StiffnessFit fit_stiffness(const Eigen::VectorXd& answered_N, const Eigen::VectorXd& recorded_N);

}  // namespace palpate
