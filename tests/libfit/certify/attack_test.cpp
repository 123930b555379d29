// What is certified creates no energy, however it is attacked, with the guard off; what fails has a
// witness that does. Failures print the seed.

#include <gtest/gtest.h>

#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

constexpr double kStep_m = 5e-5;  // of the certificate's ticks

Kind random_kind(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  return {std::pow(10, -0.7 * unit(random)), 0.3 * unit(random), unit(random)};
}

bool is_out(const Contact& contact) {
  const runtime::Vec3d rest = runtime::make_vec3<double>(contact.memory);
  return dot(rest, rest) > 1e-24;
}
constexpr unsigned kNotCovered =
    runtime::kFlagUnfinished | runtime::kFlagBlocked | runtime::kFlagBorder;

// A contact anywhere on a triangle, its rings anywhere within their limits, ring 1 beyond its by a
// tick at most; the tool held.
struct State {
  Contact contact;
  Vec3 tip;
  double depth_m;
};
State random_state(const Asset& asset, const Element& e, int t, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double p = unit(random), q = unit(random);
  if (p + q > 1) p = 1 - p, q = 1 - q;
  const Place place{{1 - p - q, p, q}};
  const double max_m = std::min(asset.max_fitted_m, double(asset.max_depth_m[t]));
  const double depth_m = max_m * std::pow(unit(random), 2);
  const runtime::Vec3d u = runtime::blended_normal(asset, t, place.n);
  const runtime::Vec3d side = normalized(cross(u, e.axis[0])), across = cross(u, side);
  const auto lateral = [&](double length) {
    const double angle = 6.283185307179586 * unit(random);
    return side * (length * std::cos(angle)) + across * (length * std::sin(angle));
  };
  const double lambda = place.blend(e.lambda),
               mu = place.blend(e.friction) + place.blend(e.friction_slope) * depth_m;
  State out;
  out.depth_m = depth_m;
  const runtime::Vec3d deflection = lateral(mu * depth_m / lambda + kStep_m * unit(random));
  double kappa[6];
  const runtime::CornerSpot corner[3] = {{asset.node(asset.corner(t, 0)), asset.control_offset},
                                         {asset.node(asset.corner(t, 1)), asset.control_offset},
                                         {asset.node(asset.corner(t, 2)), asset.control_offset}};
  runtime::Vec3d c{0, 0, 0};
  for (int i = 0; i < 6; ++i) kappa[i] = 0;
  for (int l = 0; l < 3; ++l) {
    c = c + asset.vertex_at(asset.corner(t, l)) * place.n[l];
    for (int i = 0; i < 6; ++i) kappa[i] += place.n[l] * corner[l].control(runtime::kCurvature, i);
  }
  const double height =
      depth_m + 0.5 * dot(deflection, runtime::curvature_times(kappa, deflection));
  const runtime::Vec3d x = c + u * (height - e.radius_m) + deflection;
  out.contact.has_tip = true;
  out.contact.asset_checksum = asset.checksum;
  runtime::put(x, out.contact.tip_m);
  out.contact.triangle = t;
  for (int k = 0; k < 3; ++k) out.contact.weight[k] = place.n[k];
  out.contact.arm.reach_m = e.radius_m;
  for (int i = 1; i < kRings; ++i) {
    const double reach = depth_m - e.threshold[i];
    const double limit_m = reach > 0 ? mu * reach / lambda : 0;
    const double share = unit(random) < 0.5 ? 1 : unit(random);
    runtime::put(deflection - lateral(limit_m * share), out.contact.memory + 3 * i);
  }
  out.tip = {x.x + asset.origin_m[0], x.y + asset.origin_m[1], x.z + asset.origin_m[2]};
  return out;
}

TEST(certificate, no_slip_from_any_state_of_the_rings_on_a_certified_triangle_creates_energy) {
  int slips = 0, certified = 0, created = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const Loaded body = load(random_body(seed, random_kind(seed)));
    const double radius_m = seed % 3 == 0 ? 0.004 : 0;
    const Certificate certificate = certify(body.asset, radius_m, 150);
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    ElementOptions options;
    options.radius_m = radius_m;
    const auto& element = certificate.tools[0].element;
    const auto is_certified = [&](int t) {
      const auto at = static_cast<std::size_t>(t);
      return certificate.zone[at] == Zone::interior &&
             element[at].any.verdict == Verdict::certified;
    };
    std::mt19937 random(seed);
    for (int t = 0; t < bare.triangles; ++t) {
      const auto at = static_cast<std::size_t>(t);
      if (certificate.zone[at] != Zone::interior) continue;
      certified += is_certified(t);
      const Element e = element_of(bare, t, options);
      for (int i = 0; i < 40; ++i) {
        State state = random_state(body.asset, e, t, random);
        Output out;
        touch_ball(bare, state.contact, state.tip.data(), radius_m, out);
        if (out.state != ContactState::slip || (out.flags & kNotCovered) != 0 ||
            is_out(state.contact))
          continue;
        if (!is_certified(t) || !is_certified(out.triangle)) {
          created += out.dissipated_J < 0;
          continue;
        }
        ++slips;
        ASSERT_GE(out.dissipated_J, -1e-12 * out.stored_J)
            << "seed " << seed << ", triangle " << t << " to " << out.triangle << ", state " << i
            << ", depth " << state.depth_m << ", ratio " << element[at].any.ratio << ", radius "
            << radius_m;
      }
    }
  }
  std::printf("%d slips on %d certified triangles, %d created elsewhere\n", slips, certified,
              created);
  EXPECT_GT(slips, 100000);
  EXPECT_GT(created, 1000) << "the attack is too weak to find what is not certified";
}

}  // namespace
}  // namespace palpate::certify::test
