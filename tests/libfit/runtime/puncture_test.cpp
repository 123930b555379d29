// A body that a tool punctures (docs/method.md, section 26), in the engine.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "libfit/runtime/palpate.h"
#include "libfit/runtime/tool/tool.hpp"
#include "libfit/runtime/tool/turning_tool.hpp"
#include "tests/libfit/runtime/damaged_body.hpp"

namespace palpate::test {
namespace {

constexpr double kPuncture_N = 0.8, kCutting_N = 0.2, kFriction_N_m = 10, kMouth_m = 1e-3;

runtime::DamageView sharp(double cutting_N = kCutting_N, double friction_N_m = kFriction_N_m) {
  runtime::DamageView damage;
  damage.puncture_N = kPuncture_N;
  damage.cutting_N = cutting_N;
  damage.friction_N_m = friction_N_m;
  damage.mouth_m = kMouth_m;
  return damage;
}

Model plate(const runtime::DamageView& damage, double radius_m = 0) {
  Model model = plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_rings(
      model, 0.5, radius_m, [](const Vec3&) { return 1; }, nullptr);
  model.curves.damage = damage;
  return model;
}

// A tool that is led in steps; force ON the body, and what was done on it.
struct Hand {
  explicit Hand(const runtime::AssetView& of, double radius = 0) : asset(of), radius_m(radius) {}
  Vec3 go(const Vec3& at) {
    status = touch_ball(asset, contact, at.data(), radius_m, out);
    const Vec3 now = -Vec3::Map(out.force_on_tool_N);
    if (is_led) work_J += 0.5 * (now + force_N).dot(at - x);
    is_led = true;
    x = at, force_N = now;
    punctures += (out.flags & runtime::kFlagPunctured) != 0;
    return now;
  }
  Vec3 lead(const Vec3& to, int ticks = 1000) {
    const Vec3 from = x;
    for (int k = 1; k <= ticks; ++k) go(from + (to - from) * (double(k) / ticks));
    return force_N;
  }
  bool is_in_channel() const { return (out.flags & runtime::kFlagChannel) != 0; }

  const runtime::AssetView& asset;
  double radius_m;
  Contact contact;
  Output out;
  Status status = Status::ok;
  Vec3 x{0, 0, 0}, force_N{0, 0, 0};
  double work_J = 0;
  int punctures = 0;
  bool is_led = false;
};

constexpr double kX = 1e-3, kY = 0.7e-3;

// Down to where it has just broken in; the depth.
double break_in(Hand& hand) {
  const double top_m = hand.radius_m + 1e-3;
  hand.go({kX, kY, top_m});
  for (double z = top_m; z > -0.03 && hand.punctures == 0; z -= 1e-6) hand.go({kX, kY, z});
  return -hand.x.z();
}

TEST(puncture, a_tool_breaks_in_where_its_force_reaches_what_the_body_bears_and_not_before) {
  const Loaded loaded = load(plate(sharp()));
  DamagedBody body(loaded.asset);
  Hand hand(body.view), whole(loaded.asset);
  hand.go({kX, kY, 1e-3}), whole.go({kX, kY, 1e-3});
  Output last;
  for (double z = 1e-3; hand.punctures == 0; z -= 1e-6) {
    ASSERT_GT(z, -0.03);
    last = hand.out;
    hand.go({kX, kY, z}), whole.go({kX, kY, z});
    if (hand.punctures == 0) {
      ASSERT_EQ(hand.force_N, whole.force_N);
    }
  }
  EXPECT_LT(last.force_on_tool_N[2], kPuncture_N);
  EXPECT_GE(-whole.force_N.z(), kPuncture_N);
  const double depth_m = -hand.x.z();
  EXPECT_NEAR(-hand.force_N.z(), kCutting_N + kFriction_N_m * depth_m, 1e-3);
  EXPECT_TRUE(hand.is_in_channel());
  EXPECT_LT(hand.out.stored_J, last.stored_J);
  EXPECT_NEAR(hand.out.stored_J + hand.out.dissipated_J, hand.work_J, 1e-3 * hand.work_J);
  hand.go(hand.x);
  EXPECT_EQ(hand.punctures, 1) << "once";
  EXPECT_EQ(body.view.channels->made, 1);
}

TEST(puncture, in_the_channel_it_cuts_on_slides_out_and_finds_its_hole_again) {
  const Loaded loaded = load(plate(sharp()));
  DamagedBody body(loaded.asset);
  Hand hand(body.view);
  break_in(hand);
  for (const double depth_m : {0.015, 0.02, 0.025})
    EXPECT_NEAR(-hand.lead({kX, kY, -depth_m}).z(), kCutting_N + kFriction_N_m * depth_m, 1e-4);
  EXPECT_NEAR(-hand.lead({kX, kY, -0.01}).z(), -kFriction_N_m * 0.01, 1e-6) << "on the way out";
  hand.lead({kX, kY, 1e-3});
  EXPECT_EQ(hand.force_N, Vec3(0, 0, 0));
  EXPECT_EQ(hand.out.state, ContactState::air);
  EXPECT_NEAR(hand.out.dissipated_J, hand.work_J, 2e-3 * hand.work_J) << "all of it is lost";
  for (const double depth_m : {0.004, 0.012, 0.02})
    EXPECT_NEAR(-hand.lead({kX, kY, -depth_m}).z(), kFriction_N_m * depth_m, 1e-5)
        << "in again nothing is cut";
  EXPECT_NEAR(-hand.lead({kX, kY, -0.03}).z(), kCutting_N + kFriction_N_m * 0.03, 1e-4) << "beyond";
  EXPECT_EQ(hand.punctures, 1);
  hand.lead({kX, kY, 1e-3});
  hand.lead({kX + 5 * kMouth_m, kY, 1e-3});
  hand.lead({kX + 5 * kMouth_m, kY, -0.001});
  EXPECT_FALSE(hand.is_in_channel()) << "beside the hole the surface is whole";
  EXPECT_LT(hand.force_N.z(), 0);
}

TEST(puncture, without_friction_and_cutting_the_channel_is_free) {
  const Loaded loaded = load(plate(sharp(0, 0)));
  DamagedBody body(loaded.asset);
  Hand hand(body.view);
  break_in(hand);
  EXPECT_EQ(hand.force_N, Vec3(0, 0, 0));
  for (const double z : {-0.02, -0.03, -0.005})
    EXPECT_LT(hand.lead({kX, kY, z}).norm(), 1e-15) << z;
}

TEST(puncture, the_wall_holds_a_tool_sideways_and_gives_back_what_bent_it) {
  const Loaded loaded = load(plate(sharp()));
  DamagedBody body(loaded.asset);
  Hand hand(body.view);
  break_in(hand);
  hand.lead({kX, kY, -0.025});
  const double stiffness_N_m = runtime::kWallShare * body.view.channels->channel[0].stiffness_N_m;
  const Vec3 before = hand.force_N;
  const double lost_J = hand.out.dissipated_J;
  const Vec3 aside = hand.lead(hand.x + Vec3(0.002, -0.001, 0));
  EXPECT_NEAR(aside.x(), stiffness_N_m * 0.002, 1e-6);
  EXPECT_NEAR(aside.y(), stiffness_N_m * -0.001, 1e-6);
  EXPECT_NEAR(aside.z(), before.z(), 1e-9);
  hand.lead(hand.x - Vec3(0.002, -0.001, 0));
  EXPECT_NEAR((hand.force_N - before).norm(), 0, 1e-9);
  EXPECT_NEAR(hand.out.dissipated_J, lost_J, 1e-12);
}

TEST(puncture, the_tangent_is_the_slope_of_the_force_in_a_channel) {
  const Loaded loaded = load(plate(sharp()));
  DamagedBody body(loaded.asset);
  Hand hand(body.view);
  break_in(hand);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = Vec3(kX, kY, -0.012) + Vec3(1e-3 * unit(random), 1e-3 * unit(random),
                                               0.011 * unit(random) + (i == 0 ? -0.01 : 0));
    const Contact before = hand.contact;
    const std::vector<std::uint64_t> saved = body.memory;
    const auto force = [&](const Vec3& at) {
      body.memory = saved;
      Contact contact = before;
      Output out;
      touch(body.view, contact, at.data(), out);
      return Vec3(-Vec3::Map(out.force_on_tool_N));
    };
    constexpr double kStep = 1e-8;
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k)
      slope.col(k) =
          (force(x + kStep * Vec3::Unit(k)) - force(x - kStep * Vec3::Unit(k))) / (2 * kStep);
    body.memory = saved;
    double tangent[9];
    touch(body.view, hand.contact, x.data(), hand.out, tangent);
    if (!hand.is_in_channel()) break;
    ++checked;
    for (int k = 0; k < 3; ++k)
      EXPECT_LT((Vec3(tangent[k], tangent[3 + k], tangent[6 + k]) - slope.col(k)).norm(),
                1e-4 * slope.norm())
          << "seed 3, draw " << i << " axis " << k;
  }
  EXPECT_GT(checked, 200);
}

TEST(puncture, a_ball_breaks_in_leaves_and_enters_likewise) {
  const Loaded loaded = load(plate(sharp(), 0.003));
  DamagedBody body(loaded.asset);
  Hand hand(body.view, 0.003);
  const double z = break_in(hand);
  ASSERT_EQ(hand.punctures, 1) << z;
  hand.lead({kX, kY, -0.02});
  EXPECT_NEAR(-hand.force_N.z(), kCutting_N + kFriction_N_m * 0.023, 1e-3);
  hand.lead({kX, kY, 0.01});
  EXPECT_EQ(hand.out.state, ContactState::air);
  hand.lead({kX, kY, -0.01});
  EXPECT_TRUE(hand.is_in_channel());
  EXPECT_NEAR(-hand.force_N.z(), kFriction_N_m * 0.013, 1e-4);
}

TEST(puncture, holes_are_saved_and_restored_and_bytes_that_are_none_are_refused) {
  runtime::DamageView damage = sharp();
  damage.r = 1.3, damage.scale = 0.02, damage.beta = 0.15, damage.reach_m = 0.012;
  const Loaded loaded = load(plate(damage));
  DamagedBody body(loaded.asset);
  Hand hand(body.view);
  break_in(hand);
  const std::vector<std::uint64_t> saved = body.memory;
  const Contact kept = hand.contact;
  const Vec3 first = hand.go({kX, kY + 1e-4, -0.02});
  EXPECT_NE(body.memory, saved);
  body.memory = saved, hand.contact = kept;
  ASSERT_TRUE(runtime::is_body(loaded.asset, body.memory.data(), 8 * saved.size()));
  EXPECT_EQ(hand.go({kX, kY + 1e-4, -0.02}), first);
  const std::size_t list = runtime::borne_bytes(loaded.asset) / 8;
  for (const std::size_t word : {list, list + 4, list + 7, list + 8, list + 9, list + 11}) {
    std::vector<std::uint64_t> broken = saved;
    broken[word] ^= 0xff800000ff800000u;
    EXPECT_FALSE(runtime::is_body(loaded.asset, broken.data(), 8 * broken.size())) << word - list;
  }
  runtime::start_body(loaded.asset, body.memory.data());
  hand.go({kX, kY, -0.02});
  EXPECT_EQ(hand.force_N, Vec3(0, 0, 0)) << "a healed body has no hole to be in";
  EXPECT_EQ(hand.out.state, ContactState::air);
}

TEST(puncture, numbers_that_nothing_breaks_by_are_refused) {
  const auto status_of = [](const runtime::DamageView& damage) {
    AssetBytes bytes = make_asset_bytes(plate(sharp()), {});
    const double numbers[8] = {
        damage.r,          damage.scale,     damage.beta,         damage.reach_m,
        damage.puncture_N, damage.cutting_N, damage.friction_N_m, damage.mouth_m};
    std::memcpy(bytes.data() + bytes.size() - sizeof numbers, numbers, sizeof numbers);
    runtime::Header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.checksum = runtime::asset_checksum(bytes.data(), bytes.size());
    std::memcpy(bytes.data(), &header, sizeof header);
    Status status;
    Asset::open(bytes.data(), bytes.size(), &status);
    return status;
  };
  EXPECT_EQ(status_of(sharp()), Status::ok);
  EXPECT_EQ(status_of({}), Status::numbers_wrong);
  EXPECT_EQ(status_of(sharp(kPuncture_N * 1.1)), Status::numbers_wrong);
  EXPECT_EQ(status_of(sharp(-0.1)), Status::numbers_wrong);
  EXPECT_EQ(status_of(sharp(0.1, NAN)), Status::numbers_wrong);
  runtime::DamageView mouthless = sharp();
  mouthless.mouth_m = 0;
  EXPECT_EQ(status_of(mouthless), Status::numbers_wrong);
}

// Rings, softening of two bodies in three, puncture; two tools. A tool that
// rests gains nothing, and closed motions take more than they give.
TEST(puncture, no_energy_is_made_whatever_two_tools_do) {
  int punctures = 0, entered = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    DrawnRings drawn(seed);
    Model model = drawn.model(std::pow(10, -3 * drawn.unit()));
    runtime::DamageView damage;
    if (seed % 3 != 0)
      damage = {std::pow(10, -0.5 + drawn.unit()), 0.2 * drawn.unit() + 1e-3, drawn.unit(), 0.02};
    damage.puncture_N = std::pow(10, -2 + 2 * drawn.unit());
    damage.cutting_N = damage.puncture_N * drawn.unit();
    damage.friction_N_m = 100 * drawn.unit();
    damage.mouth_m = 1e-3;
    model.curves.damage = damage;
    const Loaded loaded = load(model);
    DamagedBody body(loaded.asset);
    Hand hands[2]{Hand(body.view), Hand(body.view, seed % 2 == 0 ? 0.002 : 0)};
    const Vec3 top(0, 0, drawn.top_m());
    double most_J = 0;
    for (Hand& hand : hands) hand.go(top + Vec3(0, 0, 4e-3));
    for (int leg = 0; leg < 40; ++leg) {
      Hand& hand = leg >= 38 ? hands[leg - 38] : hands[drawn.unit() < 0.5];
      const bool lifts = drawn.unit() < 0.3, returns = drawn.unit() < 0.4;
      Vec3 to = top + Vec3(0, 0, lifts ? 4e-3 : -4e-3) +
                drawn.vector(0.004).cwiseProduct(Vec3(1, 1, lifts ? 0 : 0.9));
      if (returns) to.x() = hand.x.x(), to.y() = hand.x.y();
      if (leg >= 38) to = hand.x + Vec3(0, 0, 0.03);
      const Vec3 from = hand.x;
      const int ticks = std::max(1, static_cast<int>((to - from).norm() / 2e-5));
      for (int k = 1; k <= ticks; ++k) {
        const bool was_in = hand.is_in_channel();
        const double lost_J = hand.out.dissipated_J - hand.contact.ledger.tank_J;
        hand.go(from + (to - from) * (double(k) / ticks));
        ASSERT_EQ(hand.status, Status::ok) << "seed " << seed;
        most_J = std::max(most_J, hand.out.stored_J);
        const double now_J = hand.out.dissipated_J - hand.contact.ledger.tank_J;
        ASSERT_GE(now_J, lost_J - 1e-12 * most_J) << "seed " << seed << " leg " << leg;
        entered +=
            !was_in && hand.is_in_channel() && (hand.out.flags & runtime::kFlagPunctured) == 0;
        const double held_J = hand.out.stored_J + hand.contact.ledger.tank_J;
        hand.go(hand.x);
        ASSERT_LE(hand.out.stored_J + hand.contact.ledger.tank_J, held_J + 1e-12 * most_J)
            << "seed " << seed << " leg " << leg << " by "
            << hand.out.stored_J + hand.contact.ledger.tank_J - held_J << " flags "
            << hand.out.flags;
      }
    }
    EXPECT_GT(hands[0].work_J + hands[1].work_J, 0) << "seed " << seed;
    punctures += hands[0].punctures + hands[1].punctures;
  }
  EXPECT_GT(punctures, 50);
  EXPECT_GT(entered, 10);
}

TEST(puncture, a_tool_that_turns_takes_no_body_that_it_would_puncture) {
  Model model = plate(sharp(), 0.03);
  model.probe = sphere_spec(0.004, 0.3);
  const Loaded loaded = load(model);
  const DamagedBody body(loaded.asset);
  runtime::TurningContact contact;
  runtime::TurningOutput out;
  const runtime::Frame upright{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
  const double above_m[3] = {0, 0, 0.1};
  EXPECT_EQ(touch_turning(loaded.asset, contact, above_m, upright, out), Status::ok);
  EXPECT_EQ(touch_turning(body.view, contact, above_m, upright, out), Status::tool_wrong);
  runtime::CompoundShape ball;
  ball.balls = 1;
  ball.radius_m = loaded.asset.probe_radius_m;
  EXPECT_EQ(check_compound(loaded.asset, ball), Status::ok);
  EXPECT_EQ(check_compound(body.view, ball), Status::tool_wrong);
}

TEST(puncture, the_c_interface_tells_of_it) {
  const Loaded loaded = load(plate(sharp()));
  palpate_asset asset, body;
  ASSERT_EQ(palpate_open(&asset, loaded.bytes.data(), loaded.bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.softens, 0);
  EXPECT_EQ(info.punctures, 1);
  std::vector<std::uint64_t> memory(palpate_body_bytes(&asset) / 8);
  ASSERT_EQ(palpate_body_start(&asset, memory.data(), 8 * memory.size()), PALPATE_OK);
  ASSERT_EQ(palpate_body_open(&body, &asset, memory.data(), 8 * memory.size()), PALPATE_OK);
  palpate_contact contact;
  const palpate_tool tool = palpate_tip();
  palpate_start(&contact, &tool);
  palpate_output out;
  int events = 0, touched = 0;
  for (int k = -10; k <= 300; ++k) {
    const palpate_input in = palpate_input_at(kX, kY, -1e-4 * k);
    ASSERT_EQ(palpate_tick(&body, &contact, &in, &out), PALPATE_OK);
    events += (out.events & PALPATE_PUNCTURED) != 0;
    touched += (out.events & PALPATE_TOUCHED) != 0;
  }
  EXPECT_EQ(events, 1);
  EXPECT_EQ(touched, 1);
  EXPECT_NE(out.flags & PALPATE_FLAG_CHANNEL, 0u);
  EXPECT_EQ(out.flags & PALPATE_FLAG_PUNCTURED, 0u);
  EXPECT_NEAR(out.force_on_tool_N[2], kCutting_N + kFriction_N_m * 0.03, 1e-3);
}

}  // namespace
}  // namespace palpate::test
