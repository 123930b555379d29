// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The law of one contact for a tool at x, as the series evaluates it (series/series.hpp): hold(),
// where nothing slips; slip(), where its contact point slides and its rings slip; and rest(),
// where time passes. None of them books energy or touches what other contacts read.

#include "../law/step.hpp"
#include "memories.hpp"

namespace palpate::runtime {

/// After a slip the skew lies across the new normal; the rest position stays what it is.
inline void project_skew(Arm& arm, const Vec3d& normal) noexcept {
  const Vec3d skew = make_vec3<double>(arm.skew_m);
  put(skew - normal * dot(skew, normal), arm.skew_m);
}

/// Normal and lateral deflection of a tool.
struct Depth {
  double normal_m = 0, lateral_m = 0;
};

/// State and flags after a slip.
struct SlipReport {
  unsigned flags = 0;
  ContactState state = ContactState::stick;
};

/// Fills the output of a contact whose ball's centre or tip is at x, but for forces and energies.
/// cache: of where it stands.
inline void describe(const AssetView& asset, const ContactPoint& at, const SpotCache& cache,
                     const Depth& depth, const Vec3d& x, const SlipReport& report,
                     Output& out) noexcept {
  const Vec3d origin = make_vec3<double>(asset.origin_m);
  Vec3d c = cache.point;  // of a ball where it rests
  if (cache.is_ball) {
    const Vec3d skew = make_vec3<double>(at.arm.skew_m);
    c = c + skew + cache.normal * (at.arm.reach_m - dot(skew, cache.normal));
  }
  put(c + origin, out.contact_m);
  put(cache.is_ball ? x + cache.normal * at.arm.reach_m + origin : x + origin, out.acts_at_m);
  put(cache.normal, out.normal);
  out.triangle = at.triangle;
  for (int k = 0; k < 3; ++k) out.weight[k] = at.weight[k];
  out.normal_m = depth.normal_m;
  out.lateral_m = depth.lateral_m;
  out.state = report.state;
  out.flags |= report.flags;
  if (depth.normal_m > double(asset.max_depth_m[at.triangle])) out.flags |= PALPATE_FLAG_TOO_DEEP;
  if (cache.is_frictionless) out.flags |= PALPATE_FLAG_FRICTIONLESS;
  if (depth.normal_m > asset.max_fitted_m) out.flags |= PALPATE_FLAG_EXTRAPOLATED;
  for (int k = 0; k < 3; ++k)
    if (asset.covered[asset.corner(at.triangle, k)] != kMeasured) out.flags |= PALPATE_FLAG_OUTSIDE;
}

/// The standing spot of a contact, cached.
template <class F, bool kIsBall>
CachedSpot cached_spot(const AssetView& asset, const ContactPoint& at, SpotCache& cache) noexcept {
  if (!is_good(cache, asset, at.triangle, at.weight, kIsBall)) {
    const MeshSurface<double, kIsBall> surface(cache.corners, asset, at.triangle, at.weight,
                                               at.arm);
    fill<F>(cache, asset, at.triangle, at.weight, kIsBall, surface.standing());
  }
  return {cache.point, cache.normal, &cache, &asset};
}

/// Lets a released ball hover over a place [area coordinates n of a triangle], its centre at
/// x: its contact resumes there with nothing deflected. The normal there may pass the centre
/// by: the anchors are then under it, and draw the contact point there at the next ticks.
template <class F, bool kIsBall>
void hover(const AssetView& asset, Contact& contact, const Vec3d& x, int triangle,
           const double n[3], const Arm& arm) noexcept {
  const CurveViews& views = asset.curves;
  contact.has_lifted = true;
  contact.hover = triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = n[k];
  contact.arm.reach_m = arm.reach_m;
  put(make_vec3<double>(arm.pole_m), contact.arm.pole_m);
  auto memory = F::template load<double>(contact.memory, views.relaxation);
  const auto standing = [&]() noexcept {
    return MeshSurface<double, kIsBall>(contact.cache.corners, asset, triangle, n, contact.arm)
        .standing();
  };
  contact.arm.reach_m -= F::kinematics(views, standing(), x, memory).d.normal_m;
  auto kinematics = F::kinematics(views, standing(), x, memory);
  F::slip_anchor(views, kinematics, memory);
  F::slip(views, F::bed(views, kinematics), kinematics, memory);
  F::save(memory, contact.memory, views.relaxation);
}

/// Longest slide of the contact point in a tick in which the tool moves by `step`.
template <class T>
T slip_budget_m(const ContactPoint& at, const Vec3<T>& step) noexcept {
  using std::sqrt;
  const T squared = dot(step, step);
  const T moved = value_of(squared) > 0 ? sqrt(squared) : T(0);
  return kSlipPerStep * moved + (kFreeSlip_m + at.slip_left_m);
}

/// Lets the contact point slide; its spot is then in `cache`.
template <class F, bool kIsBall, class Kinematics, class Memory>
SlideEnd follow(const AssetView& asset, ContactPoint& at, SpotCache& cache, const Vec3d& x,
                const Vec3d& step, const Kinematics& kinematics, Memory& memory,
                SlipReport& report) noexcept {
  MeshSurface<double, kIsBall> surface(cache.corners, asset, at.triangle, at.weight, at.arm,
                                       slip_budget_m(at, step));
  auto mesh_kinematics = F::at_spot(kinematics, kinematics.spot.mesh_spot());
  const bool slips = F::is_slipping(asset.curves, mesh_kinematics);
  const SlideEnd end = slide<F>(asset.curves, x, surface, mesh_kinematics, memory);
  at.slip_left_m = end == SlideEnd::unfinished && !surface.is_spent() ? surface.budget_m() : 0;
  at.triangle = surface.triangle();
  for (int k = 0; k < 3; ++k) at.weight[k] = surface.weight(k);
  if (end != SlideEnd::stick) {
    at.pending_J = 0;
    F::transport(asset.curves, memory, mesh_kinematics.spot.point - kinematics.spot.point,
                 mesh_kinematics.spot.normal);
    if constexpr (kIsBall) {  // its rest position is the same but for rounding
      project_skew(at.arm, mesh_kinematics.spot.normal);
      mesh_kinematics.spot = surface.standing();
    }
    fill<F>(cache, asset, at.triangle, at.weight, kIsBall, mesh_kinematics.spot);
  }
  report.flags |= surface.flags();
  if (end == SlideEnd::unfinished) report.flags |= PALPATE_FLAG_UNFINISHED;
  if (end == SlideEnd::stopped) report.flags |= PALPATE_FLAG_BLOCKED;
  if (slips) report.state = ContactState::slip;
  return end;
}

/// Result of slip().
struct Slipped {
  Answer<double> law{{0, 0, 0}, 0};  ///< force on the body and E of the law
  Depth depth;
  double before_J = 0;     ///< what the contact stored before anything slipped
  bool is_booked = false;  ///< something slipped or flowed
  bool has_moved = false;  ///< the contact point, to where the other cache is
  bool is_released = false, is_lifted = false;
};

/// The contact at x slides its contact point, then ends or returns its force: the order matters (no
/// pop at lift-off). Where the body relaxes half of the tick's time passes first (M47). from: where
/// the spot of `at` is cached; to: where that of the new one is. step: of the tool itself; a
/// contact point goes no farther at a tick because the body yielded.
template <class F, bool kIsBall, class Memory>
Slipped slip(const AssetView& asset, ContactPoint& at, SpotCache& from, SpotCache& to,
             const Decay& left, const Vec3d& x, const Vec3d& step, Memory& memory,
             SlipReport& report) noexcept {
  const CurveViews& views = asset.curves;
  auto kinematics = F::kinematics(views, cached_spot<F, kIsBall>(asset, at, from), x, memory);
  Slipped slipped;
  const auto stored_J = [&]() noexcept {
    return stored_in(asset, at, F::stored_J(views, F::bed(views, kinematics), kinematics, memory),
                     Memories())
        .stored_J;
  };
  const bool flows = has_flow(asset, Memories());
  Vec3d slip_position = x;
  auto slipping = kinematics;
  if (flows) {
    slipped.before_J = stored_J();
    flow<F>(asset, at, kinematics, left, memory, Memories());
  }
  if constexpr (F::kCanRelax)
    if (F::relaxes(views)) {
      slip_position = F::slip_position(views, kinematics, x, memory);
      slipping = F::kinematics(views, kinematics.spot, slip_position, memory);
    }
  const bool moves = !(kinematics.d.normal_m > 0) || F::has_anchor_offset(memory) ||
                     F::is_slipping(views, slipping);
  if (moves) {
    if (!flows) slipped.before_J = stored_J();
    if (&to != &from) to.corners = from.corners;
    const SlideEnd end =
        follow<F, kIsBall>(asset, at, to, slip_position, step, slipping, memory, report);
    slipped.has_moved = end != SlideEnd::stick;
    kinematics = F::kinematics(
        views, cached_spot<F, kIsBall>(asset, at, slipped.has_moved ? to : from), x, memory);
    slipped.is_lifted = !(kinematics.d.normal_m > 0) && end != SlideEnd::unfinished;
    slipped.is_released = slipped.is_lifted || is_powerless(asset, at);
    if (slipped.is_released) return slipped;
  }
  const auto& bed = F::bed(views, kinematics);
  const auto response = F::slip(views, bed, kinematics, memory);
  slipped.law = F::answer(views, bed, kinematics, response);
  slipped.depth = {kinematics.d.normal_m, kinematics.d.lateral_m};
  slipped.is_booked = moves || flows || response.dissipated_J > 0;
  if (!moves && !flows)
    slipped.before_J =
        stored_in(asset, at, slipped.law.stored_J + response.dissipated_J, Memories()).stored_J;
  return slipped;
}

/// The law at x with nothing slipping.
template <class F, bool kIsBall>
Answer<double> hold(const AssetView& asset, const ContactPoint& at, SpotCache& cache,
                    const Vec3d& x, Depth& depth) noexcept {
  const CurveViews& views = asset.curves;
  const auto memory = F::template load<double>(at.memory, views.relaxation);
  const auto kinematics =
      F::kinematics(views, cached_spot<F, kIsBall>(asset, at, cache), x, memory);
  depth = {kinematics.d.normal_m, kinematics.d.lateral_m};
  const auto& bed = F::bed(views, kinematics);
  return F::answer(views, bed, kinematics, F::stick(views, bed, kinematics, memory));
}

/// Half of a tick's time passes before the tool leaves x, where the law saw it at the tick before
/// (M47). Whether anything flowed; law_J: what the law then stores.
template <class F, bool kIsBall>
bool rest(const AssetView& asset, Contact& contact, const Vec3d& x, double& law_J) noexcept {
  const CurveViews& views = asset.curves;
  auto memory = F::template load<double>(contact.memory, views.relaxation);
  const auto kinematics =
      F::kinematics(views, cached_spot<F, kIsBall>(asset, contact, contact.cache), x, memory);
  if (!(kinematics.d.normal_m > 0)) return false;
  flow<F>(asset, contact, kinematics, contact.left, memory, Memories());
  law_J = F::stored_J(views, F::bed(views, kinematics), kinematics, memory);
  F::save(memory, contact.memory, views.relaxation);
  return true;
}

/// Receives a tangent, row-major 3 x 3 [N/m]; null: none is computed.
using TangentOut = double*;

/// Derivative of the law's force ON THE BODY with respect to the place of the tip or centre, of the
/// branches that slip() takes from this contact: the path of the slip, its ends, its roots. At the
/// tick of first touch the contact point found counts as fixed.
template <class F, bool kIsBall>
void law_tangent(const AssetView& asset, const ContactPoint& at, const Decay& left, const Vec3d& x,
                 const Vec3d& step, double tangent_N_m[9]) noexcept {
  const Vec3<Jet3> tip{Jet3(x.x, 1, 0, 0), Jet3(x.y, 0, 1, 0), Jet3(x.z, 0, 0, 1)};
  Corners corners;
  MeshSurface<Jet3, kIsBall> surface(corners, asset, at.triangle, at.weight, at.arm,
                                     slip_budget_m(at, tip - widened<Jet3>(x - step)));
  auto memory = F::template load<Jet3>(at.memory, asset.curves.relaxation);
  const Vec3<Jet3> force = law_step<F>(asset.curves, tip, left, surface, memory).answer.force_N;
  for (int k = 0; k < 3; ++k) {
    tangent_N_m[k] = force.x.v[k];
    tangent_N_m[3 + k] = force.y.v[k];
    tangent_N_m[6 + k] = force.z.v[k];
  }
}

/// Moves the anchors of a contact by path_m along the surface. The contact point follows at the
/// next slip, as far as its friction carries it there.
inline void drag_anchors(const AssetView& asset, Contact& contact, const Vec3d& path_m,
                         const Vec3d& normal) noexcept {
  with_family(asset.curves, [&](auto f) noexcept {
    using F = decltype(f);
    auto memory = F::template load<double>(contact.memory, asset.curves.relaxation);
    F::transport(asset.curves, memory, path_m * -1.0, normal);
    F::transport_anchor(memory, path_m * -1.0, normal, false);
    F::save(memory, contact.memory, asset.curves.relaxation);
  });
  contact.slip_left_m += kSlipPerStep * std::sqrt(dot(path_m, path_m));
}

/// Change of the stored energy as the contact point of a ball and its anchors move over the
/// surface while the ball stays (M72): the configurational force (Eshelby, Phil. Trans. A 244
/// (1951) 87, 10.1098/rsta.1951.0016).
struct ConfigurationalForce {
  Vec3d gradient_N{0, 0, 0};  ///< along the surface
  bool holds = false;         ///< the contact point holds: its friction is not at its limit
};
template <class F>
ConfigurationalForce configurational_force(const AssetView& asset, Contact& contact) noexcept {
  const CurveViews& views = asset.curves;
  const Vec3d x = make_vec3<double>(contact.tip_m) - make_vec3<double>(contact.series.aside_m);
  MeshSurface<double, true> surface(contact.cache.corners, asset, contact.triangle, contact.weight,
                                    contact.arm);
  const auto standing = surface.standing();
  ConfigurationalForce by_place;
  {
    const auto memory = F::template load<double>(contact.memory, views.relaxation);
    const auto kinematics = F::kinematics(views, standing, x, memory);
    const auto kind = F::excess_kind(views, kinematics);
    by_place.holds = F::current_excess(views, kinematics, kind) <
                     kStickMargin * F::excess_scale(views, kinematics, kind);
  }
  const Vec3d normal = standing.normal;
  const Vec3d across = std::fabs(normal.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d tangent = normalized(cross(normal, across));
  const Vec3d directions[] = {tangent, cross(normal, tangent)};
  for (const Vec3d& direction : directions) {
    const auto path = surface.aim(standing, direction);
    if (path.is_blocked()) continue;
    const auto spot = path.at(Dual(0, 1));
    auto memory = F::template load<Dual>(contact.memory, views.relaxation);
    const Vec3<Dual> path_m = spot.point - widened<Dual>(standing.point);
    F::transport(views, memory, path_m, spot.normal);
    F::transport_anchor(memory, path_m, spot.normal, false);
    const auto kinematics = F::kinematics(views, spot, widened<Dual>(x), memory);
    Dual energy = F::stored_J(views, F::bed(views, kinematics), kinematics, memory);
    if (asset.sways) {  // at fixed sway a softer place stores less
      const Vec3d force = make_vec3<double>(contact.series.force_N);
      const double rate[3] = {value_of(path.rate[0]), value_of(path.rate[1]),
                              value_of(path.rate[2])};
      energy.v -= 0.5 * dot(force, compliance_at(asset, contact.triangle, rate).times(force));
    }
    by_place.gradient_N = by_place.gradient_N + direction * energy.v;
  }
  return by_place;
}
/// The same for the asset's family.
inline ConfigurationalForce configurational_force(const AssetView& asset,
                                                  Contact& contact) noexcept {
  return with_family(asset.curves, [&](auto f) noexcept {
    return configurational_force<decltype(f)>(asset, contact);
  });
}

/// K becomes eta K + eta' f f^T: the tangent of what is left of a force f that is multiplied by
/// eta(E).
inline void scale_tangent(double share, double slope, const Vec3d& f, double K[9]) noexcept {
  const double v[3] = {f.x, f.y, f.z};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) K[3 * i + j] = share * K[3 * i + j] + slope * (v[i] * v[j]);
}

}  // namespace palpate::runtime
