#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

inline constexpr int kFaceNodes = 6;
inline constexpr int kFacePoints = 6;
inline constexpr int kFaceBlocks = kFaceNodes * (kFaceNodes + 1) / 2;  ///< node pairs a >= b

/// A quadrature point of the reference triangle with the six-node shape functions there and their
/// derivatives by the area coordinates r, s of corners 1 and 2.
struct FacePoint {
  double weight;
  std::array<double, kFaceNodes> shape, shape_r, shape_s;
};

constexpr FacePoint face_point(double weight, double r, double s) {
  const double t = 1 - r - s;
  return {weight,
          {t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t},
          {1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s},
          {1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)}};
}

/// Places of a face's nodes [m]: three corners, then the middles of its edges.
using FaceNodes = std::array<Vec3, kFaceNodes>;

template <class Face>
FaceNodes nodes_of_face(const Points& nodes, const Face& face) {
  FaceNodes x;
  for (int a = 0; a < kFaceNodes; ++a) x[a] = nodes.row(face[a]);
  return x;
}

inline Vec3 place_at(const FacePoint& point, const FaceNodes& nodes) {
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) x += point.shape[a] * nodes[a];
  return x;
}

/// Outward normal, as long as the area per dr ds.
inline Vec3 area_normal_at(const FacePoint& point, const FaceNodes& nodes) {
  Vec3 by_r = Vec3::Zero(), by_s = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) {
    by_r += point.shape_r[a] * nodes[a];
    by_s += point.shape_s[a] * nodes[a];
  }
  return by_r.cross(by_s);
}

/// Six points, exact to degree 4, weights summing to the reference area 1/2 (Dunavant 1985,
/// doi:10.1002/nme.1620210612).
inline constexpr std::array<FacePoint, kFacePoints> kFaceRule{
    face_point(0.054975871827660934, 0.0915762135097707435, 0.0915762135097707435),
    face_point(0.054975871827660934, 0.816847572980458513, 0.0915762135097707435),
    face_point(0.054975871827660934, 0.0915762135097707435, 0.816847572980458513),
    face_point(0.111690794839005733, 0.445948490915964886, 0.445948490915964886),
    face_point(0.111690794839005733, 0.108103018168070228, 0.445948490915964886),
    face_point(0.111690794839005733, 0.445948490915964886, 0.108103018168070228)};

using Faces = Eigen::Matrix<std::int32_t, Eigen::Dynamic, kFaceNodes, Eigen::RowMajor>;

/// Pose of another probe of the same shape.
struct SecondProbe {
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
};

/// Pose of the probe: its reference point x [m] and the unit axis u into the body. And a second
/// one, if there is one.
struct ProbePose {
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  std::optional<SecondProbe> second = std::nullopt;
};

/// A quadrature point in the last accepted state. stick_Pa: traction of the tangential spring,
/// whatever its stiffness. relative: place of the surface point relative to the tip [m]. normal: of
/// the probe. gap [m]: < 0 in contact. multiplier_m: the augmented Lagrangian's multiplier over the
/// penalty [m], overlap that exerts pressure without being there. faces_probe: false on the far
/// wall of a thin body. is_second: of two probes it belongs to the second: to the nearer one, until
/// it lets go.
struct InterfacePoint {
  Vec3 stick_Pa = Vec3::Zero(), relative = Vec3::Zero(), normal = Vec3::Zero();
  double gap = 0, pressure_Pa = 0, multiplier_m = 0;
  bool faces_probe = false, is_second = false;
};

/// All points of the interface, kFacePoints of each face.
using ContactHistory = std::vector<InterfacePoint>;

/// A displacement u (#N x 3 [m]) with the probe at `pose`, and what the interface remembers of the
/// accepted state before. Refers to all three.
struct ContactTrial {
  const Points& u;
  const ProbePose& pose;
  const ContactHistory& history;
};

/// Contact terms on one face. force: dE/du_a [N]; stiffness: its derivative, blocks a >= b at
/// a(a+1)/2 + b, 3 x 3 row major [N/m]. Block (b, a) is block (a, b), not its transpose: the two
/// differ where friction is coupled.
struct FaceTerms {
  int face;
  double force[3 * kFaceNodes];
  double stiffness[9 * kFaceBlocks];
};

/// Sums over the interface. force and torque of the probe ON the body, torque about the tip, and
/// the force of a second one; all else is of both.
struct ContactTotals {
  Vec3 force_N = Vec3::Zero();
  Vec3 torque_Nm = Vec3::Zero();
  Vec3 second_force_N = Vec3::Zero();
  double energy_J = 0;        ///< incremental, for the lagged friction limit
  double normal_force_N = 0;  ///< integral of the pressure
  double area_m2 = 0;         ///< rest area under pressure
  double greatest_penetration_m = 0;
  double mean_penetration_m = 0;  ///< weighted by pressure
  int points = 0;                 ///< quadrature points under pressure
};

/// Settings of the contact law; all without dimension. R is the probe's length_m, the radius of a
/// ball.
/// stiffness: penalty k = stiffness E / R [Pa/m]. On the liver phantom (nu 0.49, 6.3 k nodes, 4
/// press and 5 drag rows) 250 took 38 Newton iterations and 8 factorizations, 500 took 73 and 28,
/// 700 took 109 and 48, most of them on overlaps that the line search has to undo. Recorded rows
/// have had an update of the multipliers (updated_multipliers).
/// rounding: pressure grows quadratically up to this penetration, in radii.
/// tangential: stick stiffness over k: the surface creeps by about 0.0013 R before it slides. 0.1
/// took two thirds of the factorizations on drags at nu 0.49, but left 3 % of the first lateral
/// force.
/// curvature: pressure, in E, up to which the curvature of the probe enters the stiffness; higher
/// ones are overlaps on the way to a solution.
struct ContactSettings {
  double stiffness = 250;
  double rounding = 2e-5;
  double tangential = 0.3;
  double curvature = 1;
};

/// Contact of the boundary faces of one mesh with a rigid probe: a penalty pressure at quadrature
/// points and Coulomb friction with return mapping (Wriggers 2006, chapters 5 and 10).
/// Not thread-safe: owns its scratch. nodes and faces must outlive it.
class ContactInterface {
 public:
  /// young_Pa: #F, small-strain modulus under each face. Faces of which all nodes are held exert no
  /// contact: the tool cannot reach what the body stands on.
  ContactInterface(const Points& nodes, const Faces& faces, const std::vector<char>& is_held,
                   const std::vector<double>& young_Pa, const Probe& probe,
                   const ContactSettings& settings = {});

  /// The history of a body at rest with the probe at `pose`.
  ContactHistory untouched(const ProbePose& pose) const;

  /// Lags Coulomb's limit: takes it and the tangent plane of every point from the pressure and
  /// place at the last accepted state or at a trial. With both frozen, friction has a potential;
  /// Coulomb's law is met when they no longer change.
  void lag_friction_limit(const ContactHistory& history);
  void lag_friction_limit(const ContactTrial& trial);

  /// lagged: for the lagged friction limit; symmetric, and with the curvature of the probe, which
  /// may make it indefinite. lagged_flat: without this. coupled: limit, tangent plane and time in
  /// contact are those of the trial, and the stiffness, no longer symmetric, contains their
  /// derivatives (consistent tangent; Wriggers 2006, chapter 5); forces are those of `lagged`
  /// where the trial's are the lagged ones. none: no terms.
  enum class Tangent { none, lagged, lagged_flat, coupled };

  /// Energy, forces and stiffness; fills terms().
  ContactTotals evaluate(const ContactTrial& trial, Tangent tangent = Tangent::lagged);

  /// The terms of the latest evaluation, faces in increasing order.
  const std::vector<FaceTerms>& terms() const { return terms_; }

  /// Incremental energy [J] for the lagged friction limit; its gradient is the sum of terms().
  double energy(const ContactTrial& trial) const;

  /// The history once a trial is accepted.
  ContactHistory accepted(const ContactTrial& trial) const;

  /// The history of an accepted state after one update of the augmented Lagrangian's multipliers
  /// (Uzawa; Simo and Laursen 1992, doi:10.1016/0045-7949(92)90540-G). Solved again from it, the
  /// same pose leaves only the second order of the penalty's overlap and the stick's creep.
  ContactHistory updated_multipliers(const ContactHistory& accepted) const;

  /// Multiplies penalty and tangential spring. States accepted before can be gone on from: what a
  /// history keeps does not depend on them.
  void stiffen(double factor);

  /// Faces of which a node is within a distance of the probe, in increasing order.
  std::vector<int> faces_near(const Points& u, const ProbePose& pose, double within_m) const;

 private:
  struct Law {
    double pressure_Pa, slope_Pa_m, energy_J_m2;
  };
  struct Friction {
    Vec3 slip, traction_Pa;
    bool slides;
  };
  struct Traction {
    Vec3 pull_Pa = Vec3::Zero();
    Mat3 by_place = Mat3::Zero();
    double energy_J = 0;
  };
  /// Coulomb's limit at a point, frozen: of the tangential spring in the plane across `normal`, for
  /// the share of the load step that the point has spent in contact.
  struct LaggedFriction {
    double limit_Pa = 0, share = 1;
    Vec3 normal = Vec3::Zero();
  };
  Law pressure_law(double gap, double stiffness) const;
  static Friction friction_law(const Vec3& relative, const LaggedFriction& lagged, double stiffness,
                               const InterfacePoint& before);
  Traction lagged_traction(const Vec3& relative, double spring, int point,
                           const InterfacePoint& before) const;
  Traction coupled_traction(const Vec3& relative, const SignedDistance& gap, const Law& law,
                            double spring, const InterfacePoint& before) const;
  bool may_touch(const ProbePose& pose, const FaceNodes& nodes, int face) const;
  /// The probe that a point belongs to.
  static SecondProbe probe_of(const ProbePose& pose, const InterfacePoint& point);
  SignedDistance distance(const Vec3& place, const SecondProbe& probe) const;
  FaceNodes nodes_of(const Points& u, int face) const;
  ContactTotals sum_over_faces(const ContactTrial& trial, Tangent tangent,
                               std::vector<FaceTerms>* terms) const;
  void add_point(const ContactTrial& trial, const FaceNodes& nodes, int q, Tangent tangent,
                 FaceTerms& terms, ContactTotals& totals, bool& touches) const;

  const Points& nodes_;
  const Faces& faces_;
  Probe probe_;
  double rounding_m_;
  double tangential_;
  double curvature_limit_m_;         // penetration
  std::vector<char> is_open_;        // #F: not all held
  std::vector<double> area_weight_;  // #F * kFacePoints [m^2]
  std::vector<double> stiffness_;    // #F [Pa/m]
  std::vector<FaceTerms> terms_;
  std::vector<LaggedFriction> lagged_;  // per point
};

}  // namespace palpate::fem
