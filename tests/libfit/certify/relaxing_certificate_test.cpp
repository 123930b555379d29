// What the certificate of slow motion says of a body that relaxes, with the guard off.

#include <gtest/gtest.h>

#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

struct Created {
  long slips = 0, ticks = 0;  ///< ticks: in which energy was created
  double most = 0;            ///< of what was stored
};
// Holds and quick slides: legs whose ticks take as long as a hold does, then legs in no time, whose
// dashpots stay where they are, so that what a tick loses is what its slips paid.
Created slide_quickly(const Loaded& body, unsigned seed, bool has_guard) {
  runtime::AssetView asset = body.asset;
  asset.has_guard = has_guard;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  Created out;
  Contact contact;
  Vec3 x(0, 0, 0.001);
  double before_J = 0, stored_J = 0;
  for (int leg = 0; leg < 120; ++leg) {
    const bool is_hold = leg % 3 == 0;
    Vec3 to = x + (is_hold ? 0.003 : 0.015) * Vec3(draw(random), draw(random), 0);
    to = to.cwiseMax(-0.025).cwiseMin(0.025);
    to[2] = -0.0095 * (is_hold ? 0.5 + 0.5 * std::abs(draw(random)) : std::abs(draw(random)));
    if (leg % 3 == 2) to[2] = x[2];
    const Vec3 from = x;
    const int steps = static_cast<int>((to - from).norm() / 5e-5) + 1;
    for (int k = 1; k <= steps; ++k) {
      x = from + (to - from) * (double(k) / steps);
      Output tick;
      EXPECT_EQ(touch(asset, contact, x.data(), tick, nullptr,
                      is_hold ? runtime::kMaxTimeStep_s : runtime::kMinTimeStep_s),
                Status::ok);
      // Under the guard a slip may spend what friction has laid by.
      const double now_J = tick.dissipated_J - (has_guard ? contact.ledger.tank_J : 0),
                   lost_J = now_J - before_J;
      if (!is_hold && tick.state == ContactState::slip) {
        ++out.slips;
        const double share = -lost_J / std::max(stored_J, 1e-9);
        out.ticks += share > 1e-11;
        out.most = std::max(out.most, share);
      }
      before_J = now_J;
      stored_J = tick.stored_J;
    }
  }
  return out;
}

Created over_bodies(double unevenness, bool has_guard) {
  Created sum;
  for (const unsigned seed : {2u, 4u, 6u}) {
    Model model = random_body(seed, {1, unevenness, 1});
    model.curves.relaxation.share = Eigen::Vector2d(0.6, 0.4);
    model.curves.relaxation.time_s = Eigen::Vector2d(1e2, 1e4);  // long against a slide
    const Loaded body = load(model);
    EXPECT_TRUE(certify(body.asset, 0, 200).certified()) << "seed " << seed;
    const Created one = slide_quickly(body, seed, has_guard);
    sum.slips += one.slips;
    sum.ticks += one.ticks;
    sum.most = std::max(sum.most, one.most);
  }
  return sum;
}

TEST(relaxing_certificate, of_slow_motion_holds_in_quick_slides_over_an_even_body) {
  const Created created = over_bodies(0, false);
  EXPECT_GT(created.slips, 5000);
  EXPECT_EQ(created.ticks, 0) << created.most;
}
// What dashpots hold grows with the stiffness under the contact, and a tool that only just touches
// pays nothing for it.
TEST(relaxing_certificate, of_slow_motion_does_not_hold_over_an_uneven_body_and_the_guard_does) {
  const Created created = over_bodies(0.06, false);
  EXPECT_GT(created.ticks, 0);
  const Created guarded = over_bodies(0.06, true);
  EXPECT_EQ(guarded.ticks, 0) << guarded.most;
}

}  // namespace
}  // namespace palpate::certify::test
