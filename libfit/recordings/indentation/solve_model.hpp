#pragma once

#include <Eigen/Core>
#include <optional>

#include "libfit/recordings/indentation/fit_model.hpp"
#include "libfit/recordings/indentation/models.hpp"

namespace palpate::recordings {

/// A curve of W readings in units of its range and rise, and the model that is fitted to it.
struct ModelProblem {
  Eigen::VectorXd x, y;  ///< W
  double range_m = 1, rise_N = 1, first_m = 0, base_N = 0;
  ModelLaw law;           ///< empty: power law
  double area_scale = 1;  ///< of the law at about full depth [m^2]
  bool has_slope = false;
  std::optional<double> contact;  ///< on the scale of x; nothing: free
};

/// A model at the least squares of a curve. squares: of what is left, scaled.
struct SolvedModel {
  ModelFit fit;
  double squares = 0, correlation_time = 1;
  Eigen::Index unknowns = 0;
};

/// Least squares over contact, amplitude, level and, where asked for, exponent and slope (M42),
/// from the best of trial contact points. All of ModelFit but bic. Nothing where the model finds no
/// contact.
std::optional<SolvedModel> solve_model(const ModelProblem& problem, const IndentationModel& model,
                                       const Indentation& press);

}  // namespace palpate::recordings
