// What is certified creates no energy, however it is attacked, with the guard off; what fails has a
// witness that does. Failures print the seed.

#include <gtest/gtest.h>

#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

using runtime::Vec3d;

constexpr double kStep_m = 5e-5;  // of the certificate's ticks

Kind random_kind(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  return {std::pow(10, -0.7 * unit(random)), 0.3 * unit(random), unit(random)};
}

bool is_out(const Contact& contact) {
  const Vec3d rest = runtime::make_vec3<double>(contact.memory);
  return dot(rest, rest) > 1e-24;
}
constexpr unsigned kNotMeant =
    runtime::kFlagUnfinished | runtime::kFlagBlocked | runtime::kFlagBorder;

struct Attacked {
  Loaded body;
  Certificate certificate;
  runtime::AssetView bare;
  double radius_m;

  Attacked(unsigned seed, const Kind& kind)
      : body(load(random_body(seed, kind))), bare(body.asset), radius_m(seed % 3 == 0 ? 0.004 : 0) {
    certificate = certify(body.asset, radius_m, 150);
    bare.has_guard = false;
  }
  bool is_interior(int t) const {
    return certificate.zone[static_cast<std::size_t>(t)] == Zone::interior;
  }
  const Sliding& any(int t) const { return certificate.tools[0].any[static_cast<std::size_t>(t)]; }
  bool is_certified(int t) const { return is_interior(t) && any(t).verdict == Verdict::certified; }
};

// A contact anywhere on a triangle, its rings anywhere within their limits, ring 1 beyond its by a
// tick at most.
SlipState random_state(const Attacked& a, const Element& e, int t, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double p = unit(random), q = unit(random);
  if (p + q > 1) p = 1 - p, q = 1 - q;
  SlipState out{{{1 - p - q, p, q}}, range_of(a.bare, t) * std::pow(unit(random), 2), {}};
  const Vec3d u = runtime::blended_normal(a.bare, t, out.place.n),
              side = normalized(cross(u, e.axis[0])), across = cross(u, side);
  const double lambda = out.place.blend(e.lambda),
               mu = out.place.blend(e.friction) + out.place.blend(e.friction_slope) * out.depth_m;
  for (int i = 0; i < kRings; ++i) {
    const double limit_m = std::max(mu * (out.depth_m - e.threshold[i]) / lambda, 0.0);
    const double length = i == 0               ? limit_m + kStep_m * unit(random)
                          : unit(random) < 0.5 ? limit_m
                                               : limit_m * unit(random);
    const double angle = 6.283185307179586 * unit(random);
    out.ring[i] = side * (length * std::cos(angle)) + across * (length * std::sin(angle));
  }
  return out;
}

TEST(certificate, no_slip_from_any_state_of_the_rings_on_a_certified_triangle_creates_energy) {
  int slips = 0, certified = 0, created = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Attacked a(seed, random_kind(seed));
    ElementOptions options;
    options.radius_m = a.radius_m;
    std::mt19937 random(seed);
    for (int t = 0; t < a.bare.triangles; ++t) {
      if (!a.is_interior(t)) continue;
      certified += a.is_certified(t);
      const Element e = element_of(a.bare, t, options);
      for (int i = 0; i < (a.is_certified(t) ? 100 : 4); ++i) {
        StagedContact staged = stage(a.bare, t, a.radius_m, random_state(a, e, t, random));
        Output out;
        touch_ball(a.bare, staged.contact, staged.tip_m, a.radius_m, out);
        if (out.state != ContactState::slip || (out.flags & kNotMeant) != 0 ||
            is_out(staged.contact))
          continue;
        if (!a.is_certified(t) || !a.is_certified(out.triangle)) {
          created += out.dissipated_J < -1e-12 * out.stored_J;
          continue;
        }
        ++slips;
        ASSERT_GE(out.dissipated_J, -1e-12 * out.stored_J)
            << "seed " << seed << ", triangle " << t << " to " << out.triangle << ", state " << i
            << ", ratio " << a.any(t).ratio << ", radius " << a.radius_m;
      }
    }
  }
  std::printf("%d slips on %d certified triangles, %d created energy elsewhere\n", slips, certified,
              created);
  EXPECT_GT(slips, 100000);
  EXPECT_GT(created, 100) << "the attack is too weak to find what is not certified";
}

}  // namespace
}  // namespace palpate::certify::test
