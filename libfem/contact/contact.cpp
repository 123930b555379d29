#include "libfem/contact/contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate::fem {
ContactInterface::ContactInterface(const Points& nodes, const Faces& faces,
                                   const std::vector<char>& is_held,
                                   const std::vector<double>& young_Pa, const Probe& probe,
                                   const ContactSettings& settings)
    : nodes_(nodes),
      faces_(faces),
      probe_(probe),
      rounding_m_(settings.rounding * probe.length_m),
      tangential_(settings.tangential),
      curvature_limit_m_(settings.curvature * probe.length_m / settings.stiffness) {
  const Points rest = Points::Zero(nodes.rows(), 3);
  for (int face = 0; face < faces.rows(); ++face) {
    bool is_open = false;
    for (int a = 0; a < kFaceNodes; ++a) is_open |= !is_held[faces(face, a)];
    is_open_.push_back(is_open);
    stiffness_.push_back(settings.stiffness * young_Pa[face] / probe.length_m);
    for (int q = 0; q < kFacePoints; ++q)
      area_weight_.push_back(kFaceRule[q].weight * area_normal(rest, face, q).norm());
  }
  limit_Pa_.assign(area_weight_.size(), 0.0);
  share_.assign(area_weight_.size(), 1.0);
  normal_.assign(area_weight_.size(), Vec3::Zero());
}

Vec3 ContactInterface::place(const Points& u, int face, int q) const {
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) {
    const int node = faces_(face, a);
    x += kFaceRule[q].shape[a] * (nodes_.row(node) + u.row(node)).transpose();
  }
  return x;
}

Vec3 ContactInterface::area_normal(const Points& u, int face, int q) const {
  const FacePoint& point = kFaceRule[q];
  Vec3 by_r = Vec3::Zero(), by_s = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) {
    const Vec3 x = nodes_.row(faces_(face, a)) + u.row(faces_(face, a));
    by_r += point.shape_r[a] * x;
    by_s += point.shape_s[a] * x;
  }
  return by_r.cross(by_s);
}

bool ContactInterface::is_second(const ProbePose& pose, const ContactHistory& history, int point) {
  return pose.second && !history.is_second.empty() && history.is_second[point];
}

const Vec3& ContactInterface::tip(const ProbePose& pose, const ContactHistory& history, int point) {
  return is_second(pose, history, point) ? pose.second->tip : pose.tip;
}

SignedDistance ContactInterface::distance(const Vec3& place, const ProbePose& pose,
                                          const ContactHistory& history, int point) const {
  return is_second(pose, history, point)
             ? probe_.distance(pose.second->axis, place - pose.second->tip)
             : probe_.distance(pose.axis, place - pose.tip);
}

bool ContactInterface::is_nearer_to_second(const Vec3& place, const ProbePose& pose) const {
  return pose.second && probe_.distance(pose.second->axis, place - pose.second->tip).distance_m <
                            probe_.distance(pose.axis, place - pose.tip).distance_m;
}

bool ContactInterface::may_touch(const Points& u, const ProbePose& pose, int face) const {
  if (!is_open_[face]) return false;
  // A quadratic patch stays within twice the spread of its nodes about their mean.
  Vec3 mean = Vec3::Zero();
  std::array<Vec3, kFaceNodes> x;
  for (int a = 0; a < kFaceNodes; ++a) {
    x[a] = (nodes_.row(faces_(face, a)) + u.row(faces_(face, a))).transpose();
    mean += x[a] / kFaceNodes;
  }
  double squared_spread = 0;
  for (const Vec3& corner : x)
    squared_spread = std::max(squared_spread, (corner - mean).squaredNorm());
  const double reach_m = 2 * std::sqrt(squared_spread);
  return probe_.min_distance_m(pose.axis, mean - pose.tip) < reach_m ||
         (pose.second &&
          probe_.min_distance_m(pose.second->axis, mean - pose.second->tip) < reach_m);
}

ContactInterface::Law ContactInterface::pressure_law(double gap, double stiffness) const {
  const double depth = -gap, r = rounding_m_;
  if (depth <= 0) return {0, 0, 0};
  if (depth < r)
    return {stiffness * depth * depth / (2 * r), stiffness * depth / r,
            stiffness * depth * depth * depth / (6 * r)};
  const double past = depth - r / 2;
  return {stiffness * past, stiffness, stiffness * (past * past / 2 + r * r / 24)};
}

double ContactInterface::share_in_contact(double gap, int point,
                                          const ContactHistory& history) const {
  const double before = history.gap[point];
  return before <= 0 ? 1.0 : -gap / (before - gap);
}

// The gap that the pressure answers to.
double ContactInterface::pressing_gap(double gap, int point, const ContactHistory& history) const {
  return gap - history.multiplier_m[point];
}

// Return map of the tangential spring: trial slip in the tangent plane, cut back to the limit.
ContactInterface::Friction ContactInterface::friction_law(const Vec3& relative, const Vec3& normal,
                                                          double limit_Pa, double share,
                                                          double stiffness, int point,
                                                          const ContactHistory& history) const {
  const Vec3 moved =
      history.stick_Pa[point] / stiffness + share * (relative - history.relative[point]);
  Friction out;
  out.slip = moved - normal * normal.dot(moved);
  out.traction_Pa = stiffness * out.slip;
  const double size = out.traction_Pa.norm();
  out.slides = size > limit_Pa;
  if (out.slides) out.traction_Pa *= limit_Pa / size;
  return out;
}

ContactInterface::Traction ContactInterface::lagged_traction(const Vec3& relative, double spring,
                                                             int point,
                                                             const ContactHistory& history) const {
  const double limit = limit_Pa_[point], share = share_[point];
  if (limit <= 0) return {};
  const Vec3& n = normal_[point];
  const Friction friction = friction_law(relative, n, limit, share, spring, point, history);
  const Mat3 plane = Mat3::Identity() - n * n.transpose();
  if (!friction.slides) return {friction.traction_Pa, share * spring * plane};
  const Vec3 along = friction.slip.normalized();
  return {friction.traction_Pa,
          share * limit / friction.slip.norm() * (plane - along * along.transpose())};
}

ContactInterface::Traction ContactInterface::coupled_traction(const Vec3& relative,
                                                              const SignedDistance& gap,
                                                              const Law& law, double spring,
                                                              int point,
                                                              const ContactHistory& history) const {
  const double limit = probe_.friction * law.pressure_Pa;
  if (limit <= 0) return {};
  const Vec3& n = gap.gradient;
  const double before = history.gap[point];
  const double share = share_in_contact(gap.distance_m, point, history);
  const Friction friction = friction_law(relative, n, limit, share, spring, point, history);
  const Vec3 travel = relative - history.relative[point];
  const Vec3 moved = history.stick_Pa[point] / spring + share * travel;
  const double opening = before - gap.distance_m;
  const Vec3 share_by_place = before <= 0 ? Vec3(Vec3::Zero()) : -before / (opening * opening) * n;
  const Mat3 plane = Mat3::Identity() - n * n.transpose();
  const Mat3 slip_by_place = share * plane + plane * travel * share_by_place.transpose() -
                             n.dot(moved) * gap.hessian - n * (gap.hessian * moved).transpose();
  if (!friction.slides) return {friction.traction_Pa, spring * slip_by_place};
  const Vec3 along = friction.slip.normalized();
  return {
      friction.traction_Pa,
      limit / friction.slip.norm() * (slip_by_place - along * (along.transpose() * slip_by_place)) -
          probe_.friction * law.slope_Pa_m * along * n.transpose()};
}

void ContactInterface::add_point(const ContactTrial& trial, int face, int q, Tangent tangent,
                                 FaceTerms& terms, ContactTotals& totals, double& normal_force,
                                 bool& touches) {
  const auto& [u, pose, history] = trial;
  const int point = kFacePoints * face + q;
  if (!history.faces_probe[point]) return;
  const Vec3 x = place(u, face, q);
  const SignedDistance gap = distance(x, pose, history, point);
  const Vec3& tip = this->tip(pose, history, point);
  // A lagged limit acts also where the surface has just come off: else the energy would jump.
  const double pressing = pressing_gap(gap.distance_m, point, history);
  const bool is_pressed = pressing < 0;
  if (!is_pressed && (tangent == Tangent::coupled || limit_Pa_[point] <= 0)) return;
  if (!touches) {
    touches = true;
    terms.face = face;
    std::fill(std::begin(terms.force), std::end(terms.force), 0.0);
    std::fill(std::begin(terms.stiffness), std::end(terms.stiffness), 0.0);
  }
  const double weight = area_weight_[point];
  const Law law = pressure_law(pressing, stiffness_[face]);
  const Vec3& n = gap.gradient;
  // Gradient and Hessian of the energy density by the place x of the surface point.
  Vec3 pull = -law.pressure_Pa * n;
  Mat3 stiffness = law.slope_Pa_m * n * n.transpose();
  if (tangent != Tangent::lagged_flat)
    stiffness -= std::min(law.pressure_Pa, curvature_limit_m_ * stiffness_[face]) * gap.hessian;
  totals.energy_J += weight * law.energy_J_m2;

  const double spring = tangential_ * stiffness_[face];
  const Traction traction = tangent == Tangent::coupled
                                ? coupled_traction(x - tip, gap, law, spring, point, history)
                                : lagged_traction(x - tip, spring, point, history);
  pull += traction.pull_Pa;
  stiffness += traction.by_place;

  const auto& shape = kFaceRule[q].shape;
  for (int a = 0; a < kFaceNodes; ++a) {
    for (int i = 0; i < 3; ++i) terms.force[3 * a + i] += weight * shape[a] * pull[i];
    for (int b = 0; b <= a; ++b) {
      const double factor = weight * shape[a] * shape[b];
      const int block = 9 * (a * (a + 1) / 2 + b);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) terms.stiffness[block + 3 * i + j] += factor * stiffness(i, j);
    }
  }
  const Vec3 force = -weight * pull;
  if (is_second(pose, history, point)) {
    totals.second_force_N += force;
  } else {
    totals.force_N += force;
    totals.torque_Nm += (x - tip).cross(force);
  }
  if (!is_pressed) return;
  totals.area_m2 += weight;
  totals.greatest_penetration_m = std::max(totals.greatest_penetration_m, -gap.distance_m);
  totals.mean_penetration_m += weight * law.pressure_Pa * std::abs(gap.distance_m);
  normal_force += weight * law.pressure_Pa;
  ++totals.points;
}

ContactTotals ContactInterface::evaluate(const ContactTrial& trial, bool with_curvature) {
  return evaluate(trial, with_curvature ? Tangent::lagged : Tangent::lagged_flat);
}

ContactTotals ContactInterface::evaluate_coupled(const ContactTrial& trial) {
  return evaluate(trial, Tangent::coupled);
}

ContactTotals ContactInterface::evaluate(const ContactTrial& trial, Tangent tangent) {
  ContactTotals totals;
  terms_.clear();
  double normal_force = 0;  // sum of pressure, what mean penetration is weighted by
  FaceTerms terms;
  for (int face = 0; face < faces_.rows(); ++face) {
    bool touches = false;
    if (may_touch(trial.u, trial.pose, face))
      for (int q = 0; q < kFacePoints; ++q)
        add_point(trial, face, q, tangent, terms, totals, normal_force, touches);
    if (touches) terms_.push_back(terms);
  }
  if (normal_force > 0) totals.mean_penetration_m /= normal_force;
  return totals;
}

double ContactInterface::energy(const ContactTrial& trial) const {
  const auto& [u, pose, history] = trial;
  double energy = 0;
  for (int face = 0; face < faces_.rows(); ++face) {
    if (!may_touch(u, pose, face)) continue;
    for (int q = 0; q < kFacePoints; ++q) {
      const int point = kFacePoints * face + q;
      if (!history.faces_probe[point]) continue;
      const Vec3 x = place(u, face, q);
      const SignedDistance gap = distance(x, pose, history, point);
      const double pressing = pressing_gap(gap.distance_m, point, history);
      energy += area_weight_[point] * pressure_law(pressing, stiffness_[face]).energy_J_m2;
      const double limit = limit_Pa_[point], share = share_[point];
      if (limit <= 0) continue;
      const double spring = tangential_ * stiffness_[face];
      const Friction friction = friction_law(x - tip(pose, history, point), normal_[point], limit,
                                             share, spring, point, history);
      const double slip = friction.slip.norm();
      energy += area_weight_[point] / share *
                (friction.slides ? limit * slip - limit * limit / (2 * spring)
                                 : spring * slip * slip / 2);
    }
  }
  return energy;
}

void ContactInterface::stiffen(double factor) {
  for (double& stiffness : stiffness_) stiffness *= factor;
  curvature_limit_m_ /= factor;
}

std::vector<int> ContactInterface::faces_near(const Points& u, const ProbePose& pose,
                                              double within_m) const {
  std::vector<int> near;
  for (int face = 0; face < faces_.rows(); ++face) {
    if (!is_open_[face]) continue;
    bool is_near = false;
    for (int a = 0; a < kFaceNodes && !is_near; ++a) {
      const int node = faces_(face, a);
      const Vec3 x = (nodes_.row(node) + u.row(node)).transpose();
      is_near = probe_.distance(pose.axis, x - pose.tip).distance_m < within_m ||
                (pose.second &&
                 probe_.distance(pose.second->axis, x - pose.second->tip).distance_m < within_m);
    }
    if (is_near) near.push_back(face);
  }
  return near;
}

}  // namespace palpate::fem
