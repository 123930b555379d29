#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/runtime/base/spline.hpp"
#include "libfit/runtime/law/coupling.hpp"
#include "libfit/runtime/law/families.hpp"
#include "libfit/runtime/law/softening.hpp"

namespace palpate {

/// A shared spline basis of one curve kind (docs/method.md, section 3).
/// Clamped B-splines of `degree` (1 to 4) over strictly increasing `knots_m` (first 0 [m]). A curve
/// is f(x) = sum_j b_j B_j(x), `size()` = pieces + degree control values b_j [N], with b_0 = 0 (so
/// f(0) = 0 exactly) and b_j <= b_{j+1} (so f' >= 0 exactly). The increments b_{j+1} - b_j >= 0 are
/// the coefficients of the I-spline basis (Ramsay 1988, doi:10.1214/ss/1177012761). Below 0 a curve
/// is 0; past the last knot it goes on along its last slope.
struct CurveBasis {
  int degree = 3;
  std::vector<double> knots_m;

  int pieces() const { return static_cast<int>(knots_m.size()) - 1; }
  int size() const { return pieces() + degree; }
};

/// A basis as numbers the engine evaluates: polynomials per interval, laid out as one block.
/// Interval i < pieces is [knots[i], knots[i+1]); interval `pieces` is the linear continuation.
/// With t = x - knots[i], local basis k (0..degree) belongs to control value b_{i+k}
/// (b_{pieces-1+k} in the continuation) and is  sum_m weights[((i*(degree+1)) + k)*(degree+1) + m]
/// t^m. integrals[i*size + j] = integral of B_j from 0 to knots[i] [m], i = 0..pieces.
struct SplineTables {
  int degree = 0;
  int pieces = 0;
  std::vector<double> knots;      ///< pieces + 1 [m]
  std::vector<double> weights;    ///< (pieces + 1) x (degree + 1) x (degree + 1)
  std::vector<double> integrals;  ///< (pieces + 1) x size
};

/// Tables as the engine's templates read them. Not valid after `tables` is gone.
inline runtime::SplineView view(const SplineTables& tables) {
  return {tables.degree, tables.pieces, tables.knots.data(), tables.weights.data(),
          tables.integrals.data()};
}

/// Greville abscissa of control value j: the mean of the knots between the ends of B_j.
double greville_m(const CurveBasis& basis, int j);

/// Throws Error when the degree is not 1..4, there are fewer than 2 knots, the first is not 0, or
/// knots do not increase by at least 1e-9 of their range (de Boor 1978, chapter X).
SplineTables tabulate(const CurveBasis& basis);

/// The rising curves that families begin with (docs/method.md, sections 2 to 4), all in N over m:
/// normal f^z(dz), which all have, lateral f^r(dr), limit L(dz). People are shown mu = L / f^z.
enum class CurveKind : int { normal = 0, lateral = 1, limit = 2 };
inline constexpr int kCurveKinds = runtime::kCurves;
inline constexpr std::array<std::string_view, kCurveKinds> kCurveNames{"normal", "lateral",
                                                                       "limit"};

/// Numbers of one part of a curve set, a row per point. Every value is one that a float32 holds
/// exactly, so what was fitted and scored is what an asset stores.
using Controls = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The law that makes forces and the stored energy of a contact point of its parts: a row of
/// libfit/runtime/law/families.hpp.
using CurveFamily = runtime::Family;

struct CurveFamilyName {
  CurveFamily family;
  std::string_view name;
};
inline constexpr auto kCurveFamilyNames = [] {
  std::array<CurveFamilyName, runtime::kFamilies> names{};
  for (std::size_t i = 0; i < names.size(); ++i)
    names[i] = {static_cast<CurveFamily>(i), runtime::row_of(static_cast<CurveFamily>(i)).name};
  return names;
}();
constexpr std::string_view name_of(CurveFamily family) { return runtime::row_of(family).name; }

/// The parts that a node of a family owns; the first curves_of() are the curve kinds.
inline std::span<const runtime::Part> parts_of(CurveFamily family) {
  const runtime::FamilyRow& row = runtime::row_of(family);
  return {row.part, static_cast<std::size_t>(row.parts)};
}
inline std::size_t curves_of(CurveFamily family) {
  return static_cast<std::size_t>(runtime::row_of(family).curves);
}
/// Control values that a node has of a part, each of part.width numbers.
inline int size_of(const runtime::Part& part, const CurveBasis& basis) {
  return part.is_curve() ? basis.size() : part.count;
}

/// True if a fit knows standard errors of a part's numbers: not those of curves, which have bands,
/// nor of what the surface tells.
inline bool has_deviation(const runtime::Part& part) {
  return !part.is_curve() && part.known == runtime::Known::no;
}

/// Curves of many points on bases shared by the body, part by part of their family.
struct CurveSet {
  CurveFamily family = CurveFamily::separable;
  std::vector<CurveBasis> basis =
      std::vector<CurveBasis>(kCurveKinds);  ///< of each part; no knots where it is numbers
  /// Per part # x width size_of() numbers, control value by control value.
  std::vector<Controls> control = std::vector<Controls>(kCurveKinds);
  Relaxation relaxation;           ///< of the body: the curves are those of slow motion
  runtime::DamageView damage;      ///< of the body: the curves are those of first loading
  runtime::CouplingView coupling;  ///< of the body: how tools feel each other
  /// Depth of a press's first row [m]: below it nothing was measured. 0: not known.
  double first_row_m = 0;

  CurveSet() = default;
  explicit CurveSet(CurveFamily of)
      : family(of), basis(parts_of(of).size()), control(parts_of(of).size()) {}
  Eigen::Index points() const { return control[0].rows(); }
};

/// Forces and stiffnesses of the nodes of a curve set as people are shown them, whatever its
/// family. The set must outlive it.
class NodeForces {
 public:
  explicit NodeForces(const CurveSet& curves) : curves_(curves) {
    for (std::size_t kind = 0; kind < curves_of(curves.family); ++kind)
      tables_.push_back(tabulate(curves.basis[kind]));
  }

  double normal_N(Eigen::Index row, double depth_m) const {
    return runtime::curve_value(view(CurveKind::normal), of(CurveKind::normal, row), depth_m);
  }
  double normal_slope_N_m(Eigen::Index row, double depth_m) const {
    return runtime::curve_slope(view(CurveKind::normal), of(CurveKind::normal, row), depth_m);
  }
  /// Lateral force at which a tool slides: L(d), or mu(d) f^z(d) of rings.
  double limit_N(Eigen::Index row, double depth_m) const {
    if (tables_.size() == kCurveKinds)
      return runtime::curve_value(view(CurveKind::limit), of(CurveKind::limit, row), depth_m);
    const double mu = curves_.control[runtime::kFriction](row, 0) +
                      curves_.control[runtime::kFrictionSlope](row, 0) * depth_m;
    return std::max(mu, 0.0) * normal_N(row, depth_m);
  }
  /// Lateral stiffness of a tool pressed straight to a depth.
  double lateral_slope_N_m(Eigen::Index row, double depth_m) const {
    if (tables_.size() == kCurveKinds)
      return runtime::curve_slope(view(CurveKind::lateral), of(CurveKind::lateral, row), 0);
    return curves_.control[runtime::kLambda](row, 0) * normal_slope_N_m(row, depth_m);
  }

 private:
  runtime::SplineView view(CurveKind kind) const {
    return palpate::view(tables_[static_cast<int>(kind)]);
  }
  const double* of(CurveKind kind, Eigen::Index row) const {
    return curves_.control[static_cast<int>(kind)].row(row).data();
  }

  const CurveSet& curves_;
  std::vector<SplineTables> tables_;
};

/// Outcome of the fit of one test point.
enum class FitStatus : std::int8_t {
  good = 0,
  underdetermined = 1,  ///< too few rows of a kind recorded; curves filled as the message says
  poor = 2,             ///< fitted, residual above the tolerance
  failed = 3,           ///< no curve; the point is left out of refinement
};

/// Unknowns of recordings that a fit found besides the curves; a row per experiment, none when
/// nothing was unknown. The tip was `contact_m` deeper than recorded, the sensor read bias + drift
/// t along the normal, t from -1/2 to 1/2 along the experiment. Deviations are 0 for what was
/// known.
struct FittedRecordings {
  std::vector<std::int32_t> experiment, point;  ///< of the samples
  Eigen::VectorXd contact_m, contact_deviation_m;
  Eigen::VectorXd bias_N, bias_deviation_N;
  Eigen::VectorXd drift_N, drift_deviation_N;
};

/// Curves at the test points: curves.h5 in memory. P points.
struct FittedCurves {
  Points position;                ///< P x 3 [m]
  Points normal;                  ///< P x 3, inward unit
  std::vector<std::string> name;  ///< P
  CurveSet curves;
  std::vector<FitStatus> status;     ///< P
  std::vector<std::string> message;  ///< P, what is to be known of the point; mostly empty
  Eigen::VectorXd rms_residual_N;    ///< P, over the good rows; NaN without any
  Eigen::VectorXd max_residual_N;    ///< P
  Eigen::VectorXd depth_range_m;     ///< P, deepest good row: past it curves are extrapolated
  /// Uncertainty of the curves (docs/method-identification.md, section 14): P x n (n + 1) / 2 [N^2]
  /// for a kind of n increments, the covariance of those of each point, lower triangle row by row;
  /// NaN for a curve that no row speaks of. No columns when unknown.
  std::array<Controls, kCurveKinds> covariance;
  /// Standard errors of the numbers of each part that is no curve, as `control` has them: P x width
  /// count, NaN where unknown. No columns of curves, of what the surface tells, and when unknown.
  std::vector<Controls> deviation;
  FittedRecordings recordings;
  std::optional<ProbeSpec> probe;  ///< of the samples
};

/// Motion of the surface under a tool (docs/method-body.md, section 20), P test points, V vertices,
/// K modes; all numbers exact in float32. No rows of `point` where it is not known.
struct ShapeResponse {
  int intervals = 0, modes = 0;
  int radius_power = 1;  ///< a = radius_m (d / depth_m)^(radius_power / 2)
  double depth_m = 0;    ///< deepest press
  double radius_m = 0;   ///< contact radius there
  Controls point;        ///< P x runtime::shape_numbers
  Eigen::VectorXd drag;  ///< runtime::shape_drag_numbers
  Controls mode;         ///< V x 3 K, of each mode x, y, z
};

/// Curves on every fine node: model.h5 in memory. V vertices of the fine surface.
struct Model {
  Surface surface;
  Points inward_normal;          ///< V x 3 unit, u_l
  CurveSet curves;               ///< V rows; zero where not covered
  std::vector<char> is_covered;  ///< V: a test-point triangle answers for the vertex
  /// V x 3 test points that the vertex blends and their weights (sum 1; 0 where not covered).
  Triangles blend_point;
  Points blend_weight;
  std::optional<ProbeSpec> probe;  ///< of the experiments; none where unknown
  ShapeResponse shape;
};

}  // namespace palpate
