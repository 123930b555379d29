// What a contact point keeps while it stands (spot_cache.hpp) saves time and changes no bit.

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

bool is_same(const Output& a, const Output& b) {
  const auto same = [](const double* p, const double* q, std::size_t n) {
    return std::memcmp(p, q, n * sizeof(double)) == 0;
  };
  return same(a.force_on_tool_N, b.force_on_tool_N, 3) && same(a.contact_m, b.contact_m, 3) &&
         same(a.acts_at_m, b.acts_at_m, 3) && same(a.normal, b.normal, 3) &&
         same(a.weight, b.weight, 3) && same(&a.normal_m, &b.normal_m, 1) &&
         same(&a.lateral_m, &b.lateral_m, 1) && same(&a.stored_J, &b.stored_J, 1) &&
         same(&a.dissipated_J, &b.dissipated_J, 1) && same(&a.refused_J, &b.refused_J, 1) &&
         a.refused_ticks == b.refused_ticks && a.triangle == b.triangle && a.state == b.state &&
         a.flags == b.flags;
}

// Curves of several pieces and of every degree in turn; some bodies have rings.
Loaded random_body(unsigned seed, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Model model = seed % 3 == 0 ? sphere_model(0.03, 16, uniform(400, 300, 0.3))
                              : plate_model(0.1, 16, uniform(400, 300, 0.3));
  const Eigen::Index vertices = model.surface.vertices.rows();
  if (seed % 4 == 3) {
    make_rings(
        model, 0.3, seed % 3 == 0 ? 0.03 : 0, [&](const Vec3&) { return 0.5 + unit(random); },
        [&](const Vec3&) { return Vec3(300 * unit(random), 300 * unit(random), 0); });
    return load(model);
  }
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const int degree = 1 + static_cast<int>((seed + kind) % 4);
    const CurveBasis basis{degree, {0, 0.0005, 0.001, 0.0015, 0.002, 0.003, 0.0045, 0.006}};
    model.curves.basis[kind] = basis;
    Controls& control = model.curves.control[kind] = Controls::Zero(vertices, basis.size());
    const double scale = (kind == 2 ? 1 + seed % 3 * 2 : 3) / double(basis.size());
    for (Eigen::Index v = 0; v < vertices; ++v)
      for (int j = 1; j < basis.size(); ++j)
        control(v, j) = control(v, j - 1) + scale * (0.5 + unit(random));
  }
  return load(model);
}

TEST(spot_cache, a_contact_that_forgets_it_at_every_tick_feels_the_same_bits) {
  long filled = 0, slips = 0, ticks = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    const Loaded body = random_body(seed, random);
    const double top_m = seed % 3 == 0 ? 0.03 : 0, radius_m = seed % 4 == 0 ? 0.002 : 0;
    Contact kept, forgetful;
    Output a, b;
    Vec3 x(0.001, 0.002, top_m + radius_m + 0.001), goal = x;
    for (int tick = 0; tick < 20000; ++tick) {
      if (tick % 150 == 0)
        goal = Vec3(0.008 * share(random), 0.008 * share(random),
                    top_m + radius_m - 0.0025 + 0.0035 * share(random));
      x += (goal - x) * 0.02;
      filled += kept.cache.basis != nullptr;
      runtime::clear(forgetful.cache);
      touch_ball(body.asset, kept, x.data(), radius_m, a);
      touch_ball(body.asset, forgetful, x.data(), radius_m, b);
      ASSERT_TRUE(is_same(a, b)) << "seed " << seed << ", tick " << tick;
      slips += a.state == ContactState::slip;
      ++ticks;
    }
  }
  EXPECT_GT(filled, ticks / 5) << "nothing was held: the test shows nothing";
  EXPECT_GT(slips, ticks / 20);
}

// The guess of a slip's root comes from the slip before: it is part of the contact.
TEST(spot_cache, a_copied_contact_goes_on_with_the_same_bits) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    const Loaded body = random_body(seed, random);
    const double top_m = seed % 3 == 0 ? 0.03 : 0, radius_m = 0.004;
    const auto centre = [&](int tick) {
      return Vec3(0.006 * std::sin(0.02 * tick), 0.004 * std::sin(0.031 * tick),
                  top_m + radius_m - 0.002 + 0.0025 * std::cos(0.011 * tick));
    };
    Contact contact;
    Output out;
    int slips = 0;
    for (int tick = 0; tick < 2000; ++tick) {
      if (tick % 50 == 0) {
        Contact copied = contact, original = contact;
        runtime::clear(copied.cache);
        for (int later = tick; later < tick + 50; ++later) {
          Output again;
          touch_ball(body.asset, original, centre(later).data(), radius_m, out);
          touch_ball(body.asset, copied, centre(later).data(), radius_m, again);
          ASSERT_TRUE(is_same(out, again)) << "seed " << seed << ", tick " << later;
        }
      }
      touch_ball(body.asset, contact, centre(tick).data(), radius_m, out);
      slips += out.state == ContactState::slip;
    }
    EXPECT_GT(slips, 100) << "seed " << seed;
  }
}

TEST(spot_cache, is_not_read_at_another_place_or_by_another_tool) {
  const Loaded soft = load(plate_model(0.1, 20, uniform(400, 300, 0.4)));
  Tool tool(soft.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
  ASSERT_NE(tool.contact.cache.basis, nullptr);
  const double tip[3] = {0, 0.001, -0.003};
  Output out;
  Contact moved = tool.contact;
  moved.weight[0] = 0.5, moved.weight[1] = 0.25, moved.weight[2] = 0.25;
  Contact bare = moved;
  runtime::clear(bare.cache);
  Output expected;
  touch(soft.asset, moved, tip, out);
  touch(soft.asset, bare, tip, expected);
  EXPECT_TRUE(is_same(out, expected));
  moved = tool.contact;
  moved.arm.reach_m = 0.001;  // as a ball's
  bare = moved;
  runtime::clear(bare.cache);
  touch_ball(soft.asset, moved, tip, 0.001, out);
  touch_ball(soft.asset, bare, tip, 0.001, expected);
  EXPECT_TRUE(is_same(out, expected));
  EXPECT_NE(expected.normal_m, tool.out.normal_m);
}

}  // namespace
}  // namespace palpate::test
