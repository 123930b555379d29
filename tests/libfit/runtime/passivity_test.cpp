// What the engine promises about energy and jumps on uneven bodies (docs/method.md, section 18).
// Failures print the seed.

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

// Stiffness that is soft at -x, stiff at +x, or another at each node.
enum class Unevenness { even, smooth, rough };

Model body(unsigned seed, Unevenness how, double friction) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const bool is_round = seed % 2 == 1;
  Model model = is_round ? sphere_model(0.03, 24, uniform(400, 300, 0.3))
                         : plate_model(0.08, 16, uniform(400, 300, 0.3));
  const auto scale = [&](const Vec3& x) {
    return how == Unevenness::even     ? 1
           : how == Unevenness::smooth ? 1 + 25 * x[0]
                                       : 0.4 + 1.2 * unit(random);
  };
  const auto side = [&](const Vec3&) {
    return Vec3(how == Unevenness::rough ? drawn_vector(random, 500) : Vec3(Vec3::Zero()));
  };
  if (seed % 4 < 2) {
    make_rings(model, friction, is_round ? 0.03 : 0, scale, side);
    return model;
  }
  const auto curves = [&](const Vec3& x) {
    const double here = scale(x);
    return PointCurves{[=](double d) { return here * (12 * d + 4500 * d * d); },
                       [=](double d) { return here * 300 * d; },
                       [=](double d) { return friction * 0.3 * here * (12 * d + 4500 * d * d); }};
  };
  set_curves(model, curves, 0.01, 8);
  return model;
}

// Random straight legs in and over the body's top, with lifts, one at the end.
std::vector<Vec3> legs(std::mt19937& random, unsigned seed) {
  const Vec3 top(0, 0, seed % 2 == 1 ? 0.03 : 0);
  std::vector<Vec3> out{top + Vec3(0, 0, 0.001)};
  for (int leg = 0; leg < 7; ++leg)
    out.push_back(top + Vec3(0, 0, leg == 3 ? 0.001 : -0.003) +
                  drawn_vector(random, 0.004).cwiseProduct(Vec3(1, 1, leg == 3 ? 0 : 0.7)));
  out.push_back(Vec3(out.back()[0], out.back()[1], top[2] + 0.002));
  out.push_back(out.front());
  return out;
}

struct Walk {
  Tool tool;
  double max_stored_J = 0, quadrature_J = 0;
  Vec3 x, before_N = Vec3::Zero();

  Walk(const Asset& asset, const Vec3& start, double radius_m, double dt_s = 0)
      : tool(asset, radius_m, dt_s) {
    tick(x = start);
  }
  Vec3 tick(const Vec3& at) {
    const Vec3 f = tool.tick(at + Vec3(0, 0, tool.radius_m));
    quadrature_J += 0.5 * (f + before_N).dot(at - x);
    before_N = f;
    x = at;
    max_stored_J = std::max(max_stored_J, tool.out.stored_J);
    return f;
  }
  template <class Look>
  void go(const Vec3& to, double step_m, const Look& look) {
    const Vec3 from = x;
    const int ticks = std::clamp(static_cast<int>((to - from).norm() / step_m), 1, 4000);
    for (int k = 1; k <= ticks; ++k) {
      tick(from + (to - from) * (double(k) / ticks));
      look();
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  // The exact work so far: energies at the contact point held while the tool moved.
  double work_J() const { return tool.out.stored_J + tool.out.dissipated_J; }
};

// Friction down to a thousandth; bodies of rings relax from seed 241 on, in ticks of 10 us to 10 s.
TEST(passivity, stored_energy_and_tank_never_rise_without_work_at_any_tick_length) {
  int owed = 0, paid = 0;
  for (unsigned seed = 1; seed <= 560; ++seed) {
    const bool relaxes = seed > 240;
    if (relaxes && seed % 4 > 1) continue;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double friction = std::pow(10, -3 * unit(random));
    const auto how = static_cast<Unevenness>(seed % 3);
    Model model = body(seed, how, friction);
    if (relaxes) {
      model.curves.relaxation.share = std::pow(10, unit(random)) * Eigen::Vector2d(0.5, 0.8);
      model.curves.relaxation.time_s = Eigen::Vector2d(0.05, 0.6);
      if (seed % 4 == 1) model.curves.relaxation.radius_m = 8e-3;  // slides renew material
    }
    const Loaded asset = load(model);
    const auto way = legs(random, seed);
    Walk walk(asset.asset, way[0], seed % 5 == 0 ? 0.003 : 0,
              relaxes ? std::pow(10, -5 + 6 * unit(random)) : 0);
    const double step_m = std::pow(10, -5 + 3 * unit(random));  // 10 um to 1 cm
    double lost_J = 0;
    for (const Vec3& to : way)
      walk.go(to, step_m, [&] {
        const runtime::Ledger& ledger = walk.tool.contact.ledger;
        const double now_J = walk.tool.out.dissipated_J - ledger.tank_J;
        ASSERT_GE(now_J, lost_J - 1e-12 * walk.max_stored_J) << "seed " << seed;
        ASSERT_GE(walk.tool.out.stored_J, -1e-18) << "seed " << seed;
        ASSERT_GE(walk.work_J(), -1e-12 * walk.max_stored_J) << "seed " << seed;
        ASSERT_EQ(walk.tool.status, Status::ok) << "seed " << seed;
        lost_J = now_J;
        owed += ledger.debt_J > 0;
        paid += ledger.tank_J > 0;
      });
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_EQ(walk.tool.out.state, ContactState::air) << "seed " << seed;
    EXPECT_GT(walk.max_stored_J, 1e-5) << "seed " << seed;
  }
  EXPECT_GT(owed, 1000) << "nothing was ever refused";
  EXPECT_GT(paid, 10000);
}

TEST(passivity, the_ledger_is_the_work_of_the_forces) {
  // By the trapezoid rule over steps of 2 um, which errs by the kinks of slips.
  for (unsigned seed = 1; seed <= 24; ++seed) {
    std::mt19937 random(seed);
    const double friction = seed % 3 == 0 ? 1e-3 : seed % 3 == 1 ? 0.05 : 1;
    const Loaded asset = load(body(seed, Unevenness::smooth, friction));
    const auto way = legs(random, seed);
    Walk walk(asset.asset, way[0], 0);
    double moved_J = 0, before_J = 0;
    for (const Vec3& to : way)
      walk.go(to, 2e-6, [&] {
        moved_J += std::abs(walk.tool.out.stored_J - before_J);
        before_J = walk.tool.out.stored_J;
      });
    EXPECT_NEAR(walk.quadrature_J, walk.work_J(), 0.02 * moved_J) << "seed " << seed;
    EXPECT_GT(walk.quadrature_J, -0.01 * moved_J) << "seed " << seed;
  }
}

TEST(passivity, even_flat_bodies_owe_nothing) {
  for (unsigned seed = 0; seed < 40; seed += 2) {
    std::mt19937 random(seed);
    const Loaded asset = load(body(seed, Unevenness::even, std::pow(10.0, -double(seed % 8) / 2)));
    const auto way = legs(random, seed);
    Walk walk(asset.asset, way[0], 0);
    for (const Vec3& to : way) walk.go(to, 5e-5, [] {});
    EXPECT_EQ(walk.tool.out.refused_ticks, 0) << "seed " << seed;
    EXPECT_LT(walk.tool.out.refused_J, 1e-12 * walk.max_stored_J) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate::test
