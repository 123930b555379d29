#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curve_basis.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/surface.hpp"

namespace palpate {

/// The three curves of a contact point (docs/method.md, sections 2 to 4), all in N over m:
/// normal f^z(dz), lateral f^r(dr), limit L(dz). People are shown mu = L / f^z.
enum class CurveKind : int { normal = 0, lateral = 1, limit = 2 };
inline constexpr int kCurveKinds = 3;
inline constexpr std::array<std::string_view, kCurveKinds> kCurveNames{"normal", "lateral",
                                                                       "limit"};

/// # x size() control values [N] of one curve kind, a row per point. Every value is one that a
/// float32 holds exactly, so what was fitted and scored is what an asset stores.
using Controls = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// How the stored energy of a contact point is made of its curves (docs/method.md, section 2).
/// separable: Z(dz) + R(dr). leaning: dr is counted from the lean l(dz), the lateral way that a
/// tool pressed to dz would go if nothing held it sideways. coupled: Z(dz) + G(dz) R(dr) with the
/// root of the depth for G, 1 at the last knot of the normal curve, where f^r is R'. anisotropic:
/// R is read at the length of the lateral deflection by a metric I + S, as stiff tissue fibres make
/// it.
enum class CurveFamily : std::int8_t {
  separable = 0,
  leaning = 1,
  coupled = 2,
  coupled_leaning = 3,
  anisotropic = 4,
  anisotropic_leaning = 5,
  anisotropic_coupled = 6,
  anisotropic_coupled_leaning = 7,
};
constexpr bool leans(CurveFamily family) { return (static_cast<int>(family) & 1) != 0; }
constexpr bool is_coupled(CurveFamily family) { return (static_cast<int>(family) & 2) != 0; }
constexpr bool is_anisotropic(CurveFamily family) { return (static_cast<int>(family) & 4) != 0; }
constexpr CurveFamily family_of(bool leans, bool is_coupled, bool is_anisotropic) {
  return static_cast<CurveFamily>((leans ? 1 : 0) + (is_coupled ? 2 : 0) +
                                  (is_anisotropic ? 4 : 0));
}
struct CurveFamilyName {
  CurveFamily family;
  std::string_view name;
};
inline constexpr std::array<CurveFamilyName, 8> kCurveFamilyNames{{
    {CurveFamily::separable, "separable"},
    {CurveFamily::leaning, "leaning"},
    {CurveFamily::coupled, "coupled"},
    {CurveFamily::coupled_leaning, "coupled-leaning"},
    {CurveFamily::anisotropic, "anisotropic"},
    {CurveFamily::anisotropic_leaning, "anisotropic-leaning"},
    {CurveFamily::anisotropic_coupled, "anisotropic-coupled"},
    {CurveFamily::anisotropic_coupled_leaning, "anisotropic-coupled-leaning"},
}};

constexpr std::string_view name_of(CurveFamily family) {
  return kCurveFamilyNames[static_cast<std::size_t>(family)].name;
}

/// Curves of many points on bases shared by the body.
struct CurveSet {
  std::array<CurveBasis, kCurveKinds> basis;
  std::array<Controls, kCurveKinds> control;
  /// The lean: # x 3 size() [m], x, y, z of each control value in turn, the first zero, each exact
  /// in float32, nearly tangential. No knots and no columns where the family does not lean.
  CurveBasis lean_basis{2, {}};
  Controls lean;
  /// The lateral curve is that at the last normal knot; elsewhere it is G of it (method.md M3c).
  bool is_coupled = false;
  /// The anisotropy S: # x 6 [1], xx, yy, zz, xy, xz, yz of a symmetric tensor, nearly tangential
  /// and without trace, each exact in float32 (method.md M3d). No columns where the body has none.
  Controls anisotropy;

  Eigen::Index points() const { return control[0].rows(); }
  CurveFamily family() const {
    return family_of(!lean_basis.knots_m.empty(), is_coupled, anisotropy.cols() > 0);
  }
};

/// How the fit of one test point went.
enum class FitStatus : std::int8_t {
  good = 0,
  underdetermined = 1,  ///< too few usable rows; curves filled as the message says
  poor = 2,             ///< fitted, residual above the tolerance
  failed = 3,           ///< no curve; the point is left out of refinement
};

/// What a fit found of recordings besides the curves; a row per experiment, none when nothing was
/// unknown. The tip was `contact_m` deeper than recorded, the sensor read bias + drift t along the
/// normal, t from -1/2 to 1/2 along the experiment. Deviations are 0 for what was known.
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
  std::vector<std::string> message;  ///< P, empty when good
  Eigen::VectorXd rms_residual_N;    ///< P, over the good rows; NaN without any
  Eigen::VectorXd max_residual_N;    ///< P
  Eigen::VectorXd depth_range_m;     ///< P, deepest good row: past it curves are extrapolated
  /// How far curves may be off (docs/method.md, section 14): P x n (n + 1) / 2 [N^2] for a kind of
  /// n increments, the covariance of those of each point, lower triangle row by row; NaN for a
  /// curve that no row speaks of. No columns when unknown.
  std::array<Controls, kCurveKinds> covariance;
  /// Strength of smoothing over neighbouring points by kind (method.md, section 16), 0 for none,
  /// and why.
  std::array<double, kCurveKinds> smoothing{};
  std::array<std::string, kCurveKinds> smoothing_reason;
  FittedRecordings recordings;
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
  double probe_radius_m = 0;  ///< of the experiments' probe; 0 for a point or unknown
};

}  // namespace palpate
