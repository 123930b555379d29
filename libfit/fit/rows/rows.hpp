#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {

/// Errors that a recording adds to the body's answer, by Nuisance: the tip was `contact` deeper
/// than recorded, and the sensor reads bias + drift t along the inward normal, t from -1/2 at the
/// first row to 1/2 at the last. Lengths and forces in the caller's units.
using NuisanceValues = std::array<double, kNuisances>;
inline bool is_any(const NuisanceValues& values) { return values != NuisanceValues{}; }

/// The sensor's reading without a force, at a place_in_recording().
template <class T>
T sensor_reading(const std::array<T, kNuisances>& nuisance, double place) {
  return nuisance[kBias] + nuisance[kDrift] * place;
}

/// Place of row i of n in its recording, -1/2 to 1/2.
inline double place_in_recording(std::size_t i, std::size_t n) {
  return n > 1 ? double(i) / double(n - 1) - 0.5 : 0;
}

/// One press, drag or path of a test point as the fit reads it: usable rows in step order, lengths
/// over the body's `length_m`, forces over the point's `force_N`, so that every number is of
/// order 1 whatever the body's size and stiffness.
struct PointExperiment {
  std::int32_t id = 0;
  ExperimentKind kind = ExperimentKind::press;
  /// A press that never leaves the normal, as straighten_presses() makes them, is f^z alone;
  /// everything else is replayed as a path.
  bool is_replayed = false;
  /// The tool itself leaves the normal. A press on a body that sways is replayed, and determines
  /// nothing of friction.
  bool is_drag = false;
  std::vector<Vec3> deflection;
  std::vector<Vec3> force;
  std::vector<Vec3> sway;         ///< subtracted from the deflection; none: nothing was
  std::vector<double> weight;     ///< 1 / sqrt(force_error^2 + floor^2), in 1 / force_N
  std::vector<Eigen::Index> row;  ///< in the samples
  /// Standard deviations of what is not known of the sensor beforehand; 0: known exactly.
  NuisanceValues unknown{};

  /// Deflection of the tool itself, the body's sway included.
  Vec3 tool_deflection(std::size_t i) const {
    return sway.empty() ? deflection[i] : Vec3(deflection[i] + sway[i]);
  }
};

struct PointData {
  Vec3 inward = Vec3::Zero();
  Mat3 normal_gradient = Mat3::Zero();  ///< du/dc times length_m
  double force_N = 1;                   ///< typical force, the unit of force
  Mat3 sway = Mat3::Zero();             ///< compliance C, lengths over forces; 0: none subtracted
  double depth = 0;                     ///< deepest usable row, over length_m
  double depth_m = 0;                   ///< the same [m]
  ReportedRows rows;
  std::vector<PointExperiment> experiments;
  bool has_errors = false;  ///< some row states its force error: weights are believed
  std::string problem;      ///< why nothing can be fitted; empty when something can
};

struct BodyData {
  double length_m = 1;  ///< deepest usable row of the body, the unit of length
  std::vector<PointData> points;
  double error_N = 0;  ///< median force error of the rows that state one; 0 where none does
};

/// Throws Error when arrays do not belong together, an index is out of range, a normal is not a
/// unit vector or an experiment mixes points or kinds.
void check_samples(const Samples& samples);

/// Weight floor as a fraction of the point's typical force: rows are weighted by
/// 1 / sqrt(force_error^2 + floor^2). A thousandth is what simulated presses are off by.
inline constexpr double kWeightFloor = 1e-3;

/// Rows that can be fitted, by point and experiment.
/// Only `good` and finite rows; a drag or path ends at its first row that is not. A row without
/// force error gets the median of its point's, else of the body's, else the scatter of the
/// point's own forces about smoothness.
/// Throws Error as check_samples() does.
/// sways: C of each point [m/N], or none. Deflections are then those of the tool against the
/// surface around it, the rigid motion C f of the body subtracted (docs/method-body.md, section
/// 21).
BodyData gather_experiments(const Samples& samples, const std::vector<Mat3>& sways = {});

/// Change of the inward normal [1/m] along the surface on which the tool's reference point moves
/// while it just touches (M15b): of a ball, the offset surface; of other tools, the body's own. A
/// hollow counts as no narrower than 1.4 radii. Zero where the samples know no gradient.
Mat3 offset_gradient(const Samples& samples, Eigen::Index point);

/// Depth and lateral deflection of a row about the rest normal.
inline double depth_of(const PointData& point, const Vec3& deflection) {
  return deflection.dot(point.inward);
}
inline Vec3 lateral_of(const PointData& point, const Vec3& vector) {
  return vector - vector.dot(point.inward) * point.inward;
}

/// Two unit tangents at right angles, in which a point's side force is fitted.
inline std::array<Vec3, 2> tangents_of(const Vec3& inward) {
  const Vec3 first = inward.unitOrthogonal();
  return {first, inward.cross(first)};
}

/// A point's rows by the curve that they determine when a plateau test divides stick from slip:
/// start values and evidence for a basis. The final fit does not use this division.
struct CurveRows {
  std::array<std::vector<CurveRow>, kCurveKinds> curve;
  double lateral_reach = 0;     ///< largest lateral deflection before gross slip
  double largest_friction = 0;  ///< lateral over normal force of rows that stick
  int drags = 0;                ///< experiments with a lateral deflection
  int slipping_drags = 0;       ///< drags that reach a plateau
};

/// Normal rows come from presses and drags, lateral rows from drags before their plateau, limit
/// rows from the plateau, each turned into the frame of the contact point it has then.
CurveRows curve_rows(const PointData& point);

/// Numbers rows by distinct abscissa (`share` of `range` apart) and returns how many there are.
int group_by_abscissa(std::vector<CurveRow>& rows, double range, double share);

}  // namespace palpate::fit
