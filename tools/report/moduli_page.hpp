#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::tools {

/// One recording as the page of moduli shows it. W readings of the way in; none of one refused.
struct ModulusPicture {
  std::string name, point, model, grade;  ///< grade: good, fair, poor or refused
  std::vector<std::string> reasons;
  Eigen::VectorXd travel_m, push_N, fitted_N;  ///< W; NaN where the model says nothing
  double contact_m = 0, contact_deviation_m = 0;
  double young_Pa = 0, young_deviation_Pa = 0;  ///< NaN where there is none
  std::optional<Vec3> position_m;
};

/// A page without scripts: a map of the moduli where positions are known (seen along the axis in
/// which they differ least), then every recording with its readings, contact point, fitted curve,
/// what that leaves, grade and reasons; refused and poor ones first.
std::string moduli_page(const std::string& title, std::vector<ModulusPicture> pictures);

}  // namespace palpate::tools
