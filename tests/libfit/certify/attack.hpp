#pragma once

// Random slips of the engine against what is certified.

#include <gtest/gtest.h>

#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {

constexpr double kStep_m = 5e-5;  ///< of the certificate's ticks

inline Kind random_kind(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  return {std::pow(10, -0.7 * unit(random)), 0.3 * unit(random), unit(random)};
}

/// A sway settles to 1e-9 of the force: what is stored is right to that squared, but where the
/// steps of the root were not enough.
constexpr double kSettled_J = 1e-11;

inline bool is_out(const Contact& contact) {
  return runtime::Rings::is_out(runtime::Rings::load<double>(contact.memory));
}
constexpr unsigned kNotMeant =
    runtime::kFlagUnfinished | runtime::kFlagBlocked | runtime::kFlagBorder;

/// A contact anywhere on a triangle, ring 1 beyond its limit by a tick at most. The others slide
/// with it, or are anywhere that a tick may bring them.
inline SlipState random_state(const runtime::AssetView& asset, const Facet& e, int t,
                              OtherRings others, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double p = unit(random), q = unit(random);
  if (p + q > 1) p = 1 - p, q = 1 - q;
  SlipState out{{{1 - p - q, p, q}}, range_of(asset, t) * std::pow(unit(random), 2), {}};
  const runtime::Vec3d u = runtime::blended_normal(asset, t, out.place.n),
                       side = normalized(cross(u, e.axis[0])), across = cross(u, side);
  const double lambda = out.place.blend(e.lambda),
               mu = out.place.blend(e.friction) + out.place.blend(e.friction_slope) * out.depth_m;
  const double beyond_m = kStep_m * unit(random), toward = 6.283185307179586 * unit(random);
  for (int i = 0; i < kRings; ++i) {
    const double limit_m = std::max(mu * (out.depth_m - e.threshold[i]) / lambda, 0.0);
    const bool slides = i == 0 || others == OtherRings::sliding;
    const double kind = unit(random);  // of another ring: at its limit, beyond it, within it
    const double length = slides       ? limit_m + beyond_m
                          : kind < 0.3 ? limit_m
                          : kind < 0.5 ? limit_m + kStep_m * unit(random)
                                       : limit_m * unit(random);
    const double angle = slides ? toward : 6.283185307179586 * unit(random);
    out.ring[i] = side * (length * std::cos(angle)) + across * (length * std::sin(angle));
  }
  return out;
}

/// Random legs within a plate in steps of a tick; every fourth lifts off, others wander, often only
/// a little. visit(what the engine says, energy lost in the tick [J], leg).
template <class Visit>
void walk(const runtime::AssetView& bare, unsigned seed, int legs, double deepest_m,
          const Visit& visit) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  Contact contact;
  Vec3 x(0, 0, 0.001);
  double before_J = 0;
  for (int leg = 0; leg < legs; ++leg) {
    const double reach = leg % 3 == 0 ? 0.02 : 0.002;
    Vec3 to = x + reach * Vec3(draw(random), draw(random), 0);
    to = to.cwiseMax(-0.025).cwiseMin(0.025);
    to[2] = leg % 4 == 3 ? 0.0005 : -deepest_m * std::abs(draw(random));
    const Vec3 from = x;
    const int steps = static_cast<int>((to - from).norm() / kStep_m) + 1;
    for (int k = 1; k <= steps; ++k) {
      x = from + (to - from) * (double(k) / steps);
      Output out;
      touch(bare, contact, x.data(), out);
      visit(out, out.dissipated_J - before_J, leg);
      before_J = out.dissipated_J;
    }
  }
}

struct Attack {
  int slips = 0, certified = 0, created = 0;  ///< created: where nothing was certified
  int faster = 0;  ///< slips with a longer step of the law's tool than what is certified
};
/// Slips from random states on every 16th triangle of random bodies, the guard off.
inline Attack attack(OtherRings others, Model (*body_of)(unsigned), unsigned seeds = 60) {
  Attack sum;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const Loaded body = load(body_of(seed));
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    FacetOptions options;
    options.radius_m = seed % 3 == 0 ? 0.004 : 0;
    options.max_boxes = 100;
    std::mt19937 random(seed);
    for (int t = static_cast<int>(seed % 16); t < bare.triangles; t += 16) {
      if (!(range_of(bare, t) > 0) || zone_of(bare, t) != Zone::interior) continue;
      const Sliding sliding = certify_sliding(bare, t, others, options);
      const bool is_certified = sliding.verdict == Verdict::certified;
      sum.certified += is_certified;
      const Facet e = facet_of(bare, t, options);
      for (int i = 0; i < 150; ++i) {
        const SlipState state = random_state(bare, e, t, others, random);
        StagedContact staged = stage(bare, t, options.radius_m, state);
        const runtime::Vec3d held = staged.contact.series.force();
        const runtime::Compliance give = runtime::compliance_at(bare, t, staged.contact.weight);
        Output out;
        touch_ball(bare, staged.contact, staged.tip_m, options.radius_m, out);
        if (out.state != ContactState::slip || (out.flags & kNotMeant) != 0 ||
            is_out(staged.contact) || out.triangle != t)
          continue;
        // Ring 1 began at most kStep_m beyond its limit; the law's tool went on as the sway
        // settled.
        const runtime::Vec3d on = give.times(held - staged.contact.series.force());
        if (std::sqrt(dot(on, on)) > kStep_m) {
          ++sum.faster;
          continue;
        }
        const double noise_J = 1e-12 * out.stored_J + (bare.sways ? kSettled_J * out.stored_J : 0);
        const bool dissipates = out.dissipated_J >= -noise_J;
        sum.slips += is_certified;
        sum.created += !is_certified && !dissipates;
        EXPECT_TRUE(dissipates || !is_certified)
            << "seed " << seed << ", triangle " << t << ", state " << i << ", ratio "
            << sliding.ratio << ", " << out.dissipated_J << " J of " << out.stored_J;
      }
    }
  }
  return sum;
}

}  // namespace palpate::certify::test
