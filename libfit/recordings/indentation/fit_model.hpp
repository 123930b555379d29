#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/recordings/indentation/models.hpp"

namespace palpate::recordings {

/// How a model is fitted to a way in.
struct ModelFitOptions {
  std::optional<double> contact_m = {};  ///< known; else it is free
  bool has_slope = false;                ///< of the free part, beside its level
  double force_share = 0;                ///< of the largest push that rows may have; 0: all
};

/// One model on one curve, by least squares over W readings.
struct ModelFit {
  const IndentationModel* model = nullptr;
  double young_Pa = 0, young_deviation_Pa = 0;  ///< NaN of the power law
  double contact_m = 0, contact_deviation_m = 0;
  double baseline_N = 0;                        ///< at the contact point
  double slope_N_m = 0;                         ///< of the baseline; 0 where none was asked for
  double exponent = 0, exponent_deviation = 0;  ///< of the power law; else 0
  double depth_m = 0;                           ///< of the deepest reading
  double force_N = 0;                           ///< there, by the model
  double rms_N = 0;                             ///< of what it leaves
  double misfit_N = 0;       ///< likewise of means over twentieths of the depth: what is no noise
  double bic = 0;            ///< over the least of all models of the curve
  bool is_beyond = false;    ///< the press is deeper than the model holds
  bool has_pattern = false;  ///< what it leaves goes with depth: no model of the body and sensor
  std::string remark;        ///< why it does not hold here; empty where it does
};

/// Fits every named model that is admissible (no names: all) to readings of a way in, W each:
///   push = baseline (+ slope travel) + E / (1 - nu^2) area(travel - contact)    (M42)
/// Deviations are from the covariance of the least squares, residuals that go together counted as
/// fewer. In the order of the table; bic compares them. Models that find no contact are left out.
/// Precondition: W >= 8, increasing travel in the large.
std::vector<ModelFit> fit_models(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N,
                                 const Indentation& press, const std::vector<std::string>& names,
                                 const ModelFitOptions& options);

/// A way in to fit; vectors must outlive the call.
struct ModelFitTask {
  const Eigen::VectorXd* travel_m = nullptr;
  const Eigen::VectorXd* push_N = nullptr;
  Indentation press;
  ModelFitOptions options;
};

/// fit_models of each, in parallel; nothing for one with fewer than 8 readings. Results do not
/// depend on jobs (0: all cores).
std::vector<std::vector<ModelFit>> fit_all(const std::vector<ModelFitTask>& tasks,
                                           const std::vector<std::string>& names, int jobs);

/// Push that a fit has at W travels; NaN where its model says nothing.
Eigen::VectorXd model_push_N(const ModelFit& fit, const Indentation& press,
                             const Eigen::VectorXd& travel_m);

/// Index of the model that the curve is best described by, of those with a modulus: the least bic,
/// and of equals (within 2) the more exact one; one that is not beyond where it holds, while there
/// is such a one. Nothing where there is none.
std::optional<std::size_t> best_model(const std::vector<ModelFit>& fits);

/// Deviation of the best model's modulus with that of the choice: of the models that hold there,
/// each counted with exp(-bic / 2).
double chosen_deviation_Pa(const std::vector<ModelFit>& fits, std::size_t best);

}  // namespace palpate::recordings
