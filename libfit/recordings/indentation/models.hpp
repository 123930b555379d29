#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string_view>

#include "libfit/recordings/signal/settings.hpp"

namespace palpate::recordings {

/// What pressed into what.
struct Indentation {
  Tip tip = Tip::sphere;
  double radius_m = 0;        ///< of a sphere or a flat punch; 0: unknown
  double half_angle_rad = 0;  ///< of a cone, or between a pyramid's axis and its faces; 0: unknown
  double thickness_m = 0;     ///< of the body, a layer bonded to a rigid ground; 0: a half-space
  double poisson = 0.5;
};

/// Force over E / (1 - nu^2) at a depth, and its derivative.
struct ModelForce {
  double area_m2 = 0, slope_m = 0;
};
using ModelLaw = std::function<ModelForce(double depth_m)>;

/// A row of the table of contact models of a homogeneous elastic body; docs/method-recordings.md,
/// section 22.
struct IndentationModel {
  std::string_view name;
  std::string_view summary;
  /// Whether it speaks of such a tip and body.
  bool (*is_admissible)(const Indentation& press);
  /// Precondition: is_admissible. Empty for the power law, whose exponent is fitted.
  ModelLaw (*law)(const Indentation& press);
  /// Depth up to which it is within 1 % of the exact linear solution.
  double (*valid_to_m)(const Indentation& press);
};

/// All models, of two that describe a curve equally the more exact one first; the power law last.
std::span<const IndentationModel> indentation_models();
const IndentationModel* indentation_model_named(std::string_view name);

}  // namespace palpate::recordings
