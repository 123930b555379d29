#include "libfem/contact/contact.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fem {
namespace {

// Share of a load step that a point has spent in contact, from its gap before.
double share_in_contact(double gap, double before) {
  return before <= 0 ? 1.0 : -gap / (before - gap);
}

}  // namespace

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
      area_weight_.push_back(kFaceRule[q].weight *
                             area_normal_at(kFaceRule[q], nodes_of(rest, face)).norm());
  }
  lagged_.resize(area_weight_.size());
}

FaceNodes ContactInterface::nodes_of(const Points& u, int face) const {
  FaceNodes x;
  for (int a = 0; a < kFaceNodes; ++a) x[a] = nodes_.row(faces_(face, a)) + u.row(faces_(face, a));
  return x;
}

SecondProbe ContactInterface::probe_of(const ProbePose& pose, const InterfacePoint& point) {
  return pose.second && point.is_second ? *pose.second : SecondProbe{pose.tip, pose.axis};
}

SignedDistance ContactInterface::distance(const Vec3& place, const SecondProbe& probe) const {
  return probe_.distance(probe.axis, place - probe.tip);
}

bool ContactInterface::may_touch(const ProbePose& pose, const FaceNodes& x, int face) const {
  if (!is_open_[face]) return false;
  // A quadratic patch stays within twice the spread of its nodes about their mean.
  Vec3 mean = Vec3::Zero();
  for (const Vec3& node : x) mean += node / kFaceNodes;
  double squared_spread = 0;
  for (const Vec3& node : x) squared_spread = std::max(squared_spread, (node - mean).squaredNorm());
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

// Return map of the tangential spring: trial slip in the tangent plane, cut back to the limit.
ContactInterface::Friction ContactInterface::friction_law(const Vec3& relative,
                                                          const LaggedFriction& lagged,
                                                          double stiffness,
                                                          const InterfacePoint& before) {
  const Vec3& normal = lagged.normal;
  const Vec3 moved = before.stick_Pa / stiffness + lagged.share * (relative - before.relative);
  Friction out;
  out.slip = moved - normal * normal.dot(moved);
  out.traction_Pa = stiffness * out.slip;
  const double size = out.traction_Pa.norm();
  out.slides = size > lagged.limit_Pa;
  if (out.slides) out.traction_Pa *= lagged.limit_Pa / size;
  return out;
}

ContactInterface::Traction ContactInterface::lagged_traction(const Vec3& relative, double spring,
                                                             int point,
                                                             const InterfacePoint& before) const {
  const auto& [limit, share, n] = lagged_[point];
  if (limit <= 0) return {};
  const Friction friction = friction_law(relative, lagged_[point], spring, before);
  const double slip = friction.slip.norm();
  const Mat3 plane = Mat3::Identity() - n * n.transpose();
  const double weight = area_weight_[point] / share;
  if (!friction.slides)
    return {friction.traction_Pa, share * spring * plane, weight * (spring * slip * slip / 2)};
  const Vec3 along = friction.slip.normalized();
  return {friction.traction_Pa, share * limit / slip * (plane - along * along.transpose()),
          weight * (limit * slip - limit * limit / (2 * spring))};
}

ContactInterface::Traction ContactInterface::coupled_traction(const Vec3& relative,
                                                              const SignedDistance& gap,
                                                              const Law& law, double spring,
                                                              const InterfacePoint& before) const {
  const double limit = probe_.friction * law.pressure_Pa;
  if (limit <= 0) return {};
  const Vec3& n = gap.gradient;
  const double share = share_in_contact(gap.distance_m, before.gap);
  const Friction friction = friction_law(relative, {limit, share, n}, spring, before);
  const Vec3 travel = relative - before.relative;
  const Vec3 moved = before.stick_Pa / spring + share * travel;
  const double opening = before.gap - gap.distance_m;
  const Vec3 share_by_place =
      before.gap <= 0 ? Vec3(Vec3::Zero()) : -before.gap / (opening * opening) * n;
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

void ContactInterface::add_point(const ContactTrial& trial, const FaceNodes& nodes, int q,
                                 Tangent tangent, FaceTerms& terms, ContactTotals& totals,
                                 bool& touches) const {
  const auto& [u, pose, history] = trial;
  const int face = terms.face, point = kFacePoints * face + q;
  const InterfacePoint& before = history[point];
  if (!before.faces_probe) return;
  const Vec3 x = place_at(kFaceRule[q], nodes);
  const SecondProbe probe = probe_of(pose, before);
  const SignedDistance gap = distance(x, probe);
  // A lagged limit acts also where the surface has just come off: else the energy would jump.
  const double pressing = gap.distance_m - before.multiplier_m;
  const bool is_pressed = pressing < 0;
  if (!is_pressed && (tangent == Tangent::coupled || lagged_[point].limit_Pa <= 0)) return;
  const double weight = area_weight_[point];
  const Law law = pressure_law(pressing, stiffness_[face]);
  const double spring = tangential_ * stiffness_[face];
  const Traction traction = tangent == Tangent::coupled
                                ? coupled_traction(x - probe.tip, gap, law, spring, before)
                                : lagged_traction(x - probe.tip, spring, point, before);
  totals.energy_J += weight * law.energy_J_m2;
  totals.energy_J += traction.energy_J;
  if (tangent == Tangent::none) return;
  if (!touches) {
    touches = true;
    std::fill(std::begin(terms.force), std::end(terms.force), 0.0);
    std::fill(std::begin(terms.stiffness), std::end(terms.stiffness), 0.0);
  }
  const Vec3& n = gap.gradient;
  // Gradient and Hessian of the energy density by the place x of the surface point.
  const Vec3 pull = -law.pressure_Pa * n + traction.pull_Pa;
  Mat3 stiffness = law.slope_Pa_m * n * n.transpose();
  if (tangent != Tangent::lagged_flat)
    stiffness -= std::min(law.pressure_Pa, curvature_limit_m_ * stiffness_[face]) * gap.hessian;
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
  if (pose.second && before.is_second) {
    totals.second_force_N += force;
  } else {
    totals.force_N += force;
    totals.torque_Nm += (x - probe.tip).cross(force);
  }
  if (!is_pressed) return;
  totals.area_m2 += weight;
  totals.greatest_penetration_m = std::max(totals.greatest_penetration_m, -gap.distance_m);
  totals.mean_penetration_m += weight * law.pressure_Pa * std::abs(gap.distance_m);
  totals.normal_force_N += weight * law.pressure_Pa;
  ++totals.points;
}

ContactTotals ContactInterface::sum_over_faces(const ContactTrial& trial, Tangent tangent,
                                               std::vector<FaceTerms>* terms) const {
  ContactTotals totals;
  FaceTerms of_face;
  for (of_face.face = 0; of_face.face < faces_.rows(); ++of_face.face) {
    const FaceNodes nodes = nodes_of(trial.u, of_face.face);
    if (!may_touch(trial.pose, nodes, of_face.face)) continue;
    bool touches = false;
    for (int q = 0; q < kFacePoints; ++q)
      add_point(trial, nodes, q, tangent, of_face, totals, touches);
    if (touches) terms->push_back(of_face);
  }
  if (totals.normal_force_N > 0) totals.mean_penetration_m /= totals.normal_force_N;
  return totals;
}

ContactTotals ContactInterface::evaluate(const ContactTrial& trial, Tangent tangent) {
  terms_.clear();
  return sum_over_faces(trial, tangent, &terms_);
}

double ContactInterface::energy(const ContactTrial& trial) const {
  return sum_over_faces(trial, Tangent::none, nullptr).energy_J;
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
    const bool is_near = std::ranges::any_of(nodes_of(u, face), [&](const Vec3& x) {
      return distance(x, {pose.tip, pose.axis}).distance_m < within_m ||
             (pose.second && distance(x, *pose.second).distance_m < within_m);
    });
    if (is_near) near.push_back(face);
  }
  return near;
}

ContactHistory ContactInterface::untouched(const ProbePose& pose) const {
  return accepted({Points::Zero(nodes_.rows(), 3), pose, {}});
}

void ContactInterface::lag_friction_limit(const ContactHistory& history) {
  for (std::size_t point = 0; point < lagged_.size(); ++point)
    lagged_[point] = {probe_.friction * history[point].pressure_Pa, 1, history[point].normal};
}

void ContactInterface::lag_friction_limit(const ContactTrial& trial) {
  const auto& [u, pose, history] = trial;
  if (probe_.friction <= 0) return;
  for (int face = 0; face < faces_.rows(); ++face) {
    const FaceNodes nodes = nodes_of(u, face);
    const bool is_near = may_touch(pose, nodes, face);
    for (int q = 0; q < kFacePoints; ++q) {
      const InterfacePoint& before = history[kFacePoints * face + q];
      LaggedFriction& lagged = lagged_[kFacePoints * face + q];
      lagged.limit_Pa = 0;
      if (!is_near || !before.faces_probe) continue;
      const SignedDistance gap = distance(place_at(kFaceRule[q], nodes), probe_of(pose, before));
      const double pressing = gap.distance_m - before.multiplier_m;
      lagged.limit_Pa = probe_.friction * pressure_law(pressing, stiffness_[face]).pressure_Pa;
      if (lagged.limit_Pa <= 0) continue;
      lagged.share = share_in_contact(gap.distance_m, before.gap);
      lagged.normal = gap.gradient;
    }
  }
}

ContactHistory ContactInterface::accepted(const ContactTrial& trial) const {
  const auto& [u, pose, history] = trial;
  ContactHistory next(area_weight_.size());
  for (int face = 0; face < faces_.rows(); ++face) {
    const FaceNodes nodes = nodes_of(u, face);
    for (int q = 0; q < kFacePoints; ++q) {
      InterfacePoint& here = next[kFacePoints * face + q];
      const InterfacePoint before = history.empty() ? here : history[kFacePoints * face + q];
      const Vec3 x = place_at(kFaceRule[q], nodes);
      const bool is_free =
          pose.second &&
          (history.empty() ||
           distance(x, probe_of(pose, before)).distance_m - before.multiplier_m >= 0);
      here.is_second = is_free ? distance(x, *pose.second).distance_m <
                                     distance(x, {pose.tip, pose.axis}).distance_m
                               : before.is_second;
      const SecondProbe probe = probe_of(pose, here);
      const SignedDistance gap = distance(x, probe);
      here.relative = x - probe.tip;
      here.gap = gap.distance_m;
      here.normal = gap.gradient;
      // A face whose outward normal points this far along the probe's own is the far wall of a thin
      // body. Bulged surfaces ahead of a sunken sphere reach about 0.3.
      const Vec3 outward = area_normal_at(kFaceRule[q], nodes).normalized();
      here.faces_probe = outward.dot(gap.gradient) < 0.5;
      if (history.empty() || is_free) continue;
      const double pressing = gap.distance_m - before.multiplier_m;
      if (pressing >= 0) continue;
      here.pressure_Pa = pressure_law(pressing, stiffness_[face]).pressure_Pa;
      const double limit = probe_.friction * here.pressure_Pa;
      if (limit <= 0) continue;
      const LaggedFriction lagged{limit, share_in_contact(gap.distance_m, before.gap),
                                  gap.gradient};
      here.stick_Pa =
          friction_law(here.relative, lagged, tangential_ * stiffness_[face], before).traction_Pa;
    }
  }
  return next;
}

ContactHistory ContactInterface::updated_multipliers(const ContactHistory& accepted) const {
  ContactHistory out = accepted;
  for (InterfacePoint& point : out) {
    if (point.pressure_Pa <= 0) continue;
    point.multiplier_m += std::max(0.0, -point.gap);
    point.stick_Pa *= 2;
  }
  return out;
}

}  // namespace palpate::fem
