#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

/// What is known of the recordings behind measured samples: group `recordings` of samples.h5. R
/// recordings, in the order of the manifest; several of one experiment were pooled. All empty for
/// simulated samples.
struct MeasuredRecordings {
  std::vector<std::int32_t> experiment;  ///< R, of rows/experiment
  std::vector<std::string> file;  ///< R, as the manifest names it, with `#name` within a file
  std::vector<std::string> hash;  ///< R, ContentHash of the file's bytes
  Eigen::VectorXd
      contact_m;  ///< R, travel at which the tip touched first, in the recording's own zero
  Eigen::VectorXd contact_deviation_m;  ///< R, its standard deviation: a fit with free contact
                                        ///< point starts here
  std::vector<std::string> estimator;   ///< R, that found it
  Eigen::VectorXd speed_m_s;            ///< R, loading rate; NaN without a clock
  Eigen::VectorXd noise_N;              ///< R, standard deviation of one reading without contact
  Eigen::VectorXd hysteresis;      ///< R, share of the work not given back; NaN without a way back
  Eigen::VectorXd young_Pa;        ///< R, apparent, of the contact fit; NaN where it has none
  std::vector<std::int8_t> grade;  ///< R: 0 good, 1 fair, 2 poor
  std::vector<std::string> reasons;  ///< R, of the grade; empty when good

  std::size_t size() const { return experiment.size(); }
};

}  // namespace palpate
