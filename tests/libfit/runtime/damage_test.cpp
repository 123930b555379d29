// A body that contacts damage (docs/method-body.md, section 26), in the engine.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "libfit/runtime/palpate.h"
#include "tests/libfit/assets/changed_bytes.hpp"
#include "tests/libfit/runtime/damaged_body.hpp"

namespace palpate::test {
namespace {

constexpr runtime::DamageView kSoft{1.3, 0.02, 0.15, 0.012};

Model softening(Model model, const runtime::DamageView& damage = kSoft, double friction = 0.5,
                const std::function<double(const Vec3&)>& scale = even,
                const std::function<Vec3(const Vec3&)>& side = nullptr, double radius_m = 0) {
  make_rings(model, friction, radius_m, scale, side);
  model.curves.damage = damage;
  return model;
}

// Of the law's force, that the contact bears.
double share_of(const Tool& hand) {
  if (hand.contact.triangle < 0) return 1;
  return runtime::SofteningMemory::energy(hand.asset, hand.contact, hand.contact.law_J).share;
}

TEST(damage, the_share_is_the_slope_of_what_is_stored_and_both_fall_with_what_was_borne) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const runtime::DamageView damage{std::pow(10, -1 + 2 * unit(random)), 0.5 * unit(random),
                                     unit(random) < 0.2 ? 0 : 2 * unit(random), 0};
    const double e = std::pow(10, -6 + 6 * unit(random)), most = e * 2 * unit(random),
                 E = 1.3 * most * unit(random), h = 1e-6 * most;
    SCOPED_TRACE("seed 7, draw " + std::to_string(i));
    const auto at = [&](double law_J, double most_J) {
      return runtime::softened(damage, e, most_J, law_J);
    };
    const auto now = at(E, most);
    if (std::abs(E - most) > 2 * h && E > 2 * h) {
      ASSERT_NEAR((at(E + h, most).stored_J - at(E - h, most).stored_J) / (2 * h), now.share,
                  2e-5 / damage.r + 1e-9);
      if (now.share > 0.01) {
        ASSERT_NEAR((at(E + h, most).share - at(E - h, most).share) / (2 * h) * most,
                    now.slope * most, 1e-2 * (1 + now.slope * most));
      }
    }
    ASSERT_GE(now.stored_J, 0);
    ASSERT_LE(now.stored_J, E * (1 + 1e-12));
    ASSERT_GE(now.share, 0);
    ASSERT_LE(now.share, 1);
    const auto later = at(E, most * (1 + unit(random)));
    ASSERT_LE(later.stored_J, now.stored_J + 1e-13 * most);
    ASSERT_LE(later.share, now.share + 1e-13);
  }
}

TEST(damage, a_place_pressed_again_answers_with_its_softened_force_until_it_is_pressed_deeper) {
  const Loaded loaded = load(softening(plate()));
  DamagedBody body(loaded.asset);
  Tool hand(body.view), whole(loaded.asset);
  const auto press = [&](Tool& of, double from, double to) {
    const int ticks = 200;
    for (int k = 0; k <= ticks; ++k) of.tick({1e-3, 0.7e-3, from + (to - from) * k / ticks});
  };
  for (Tool* of : {&hand, &whole}) press(*of, 1e-3, -4e-3);
  EXPECT_EQ(std::memcmp(hand.out.force_on_tool_N, whole.out.force_on_tool_N, 24), 0)
      << "first loading";
  const double most_J = whole.out.stored_J;
  const auto borne_now = [&] {
    return runtime::damage_history_at(body.view, hand.contact.triangle, hand.contact.weight);
  };
  EXPECT_LT(borne_now().most_J, most_J) << "the last of it is told when the tool goes back";
  EXPECT_GT(borne_now().most_J, 0.95 * most_J);
  for (Tool* of : {&hand, &whole}) press(*of, -4e-3, -2e-3);
  const runtime::DamageHistory borne = borne_now();
  EXPECT_NEAR(borne.most_J, most_J, 1e-6 * most_J);
  const double share = runtime::softened(kSoft, borne.unit_J, most_J, whole.out.stored_J).share;
  EXPECT_LT(share, 0.6);
  EXPECT_NEAR(hand.out.force_on_tool_N[2], share * whole.out.force_on_tool_N[2],
              1e-5 * whole.out.force_on_tool_N[2]);
  for (Tool* of : {&hand, &whole}) press(*of, -2e-3, 1e-3);
  for (Tool* of : {&hand, &whole}) press(*of, 1e-3, -2e-3);
  EXPECT_NEAR(hand.out.force_on_tool_N[2], share * whole.out.force_on_tool_N[2],
              1e-5 * whole.out.force_on_tool_N[2])
      << "and again after it was out";
  for (Tool* of : {&hand, &whole}) press(*of, -2e-3, -6e-3);
  EXPECT_NEAR(hand.out.force_on_tool_N[2], whole.out.force_on_tool_N[2],
              1e-6 * whole.out.force_on_tool_N[2])
      << "beyond";
  Tool far(body.view), far_whole(loaded.asset);
  for (Tool* of : {&far, &far_whole})
    for (int k = 0; k <= 200; ++k) of->tick({0.03, 0.03, 1e-3 - 3e-3 * k / 200});
  EXPECT_EQ(std::memcmp(far.out.force_on_tool_N, far_whole.out.force_on_tool_N, 24), 0)
      << "elsewhere";
}

TEST(damage, beside_a_place_that_has_borne_more_it_grows_without_a_jump) {
  const Loaded loaded = load(softening(plate(), {1.1, 0.01, 0.1, 0}));
  DamagedBody body(loaded.asset);
  Tool hand(body.view);
  for (double z = 1e-3; z > -6e-3; z -= 1e-5) hand.tick({0, 0, z});
  hand.tick({0, 0, 1e-3});
  hand.tick({3.1e-3, 1.4e-3, 1e-3});
  double before_N = 0, steepest_N_m = 0, softest = 1;
  for (double z = 1e-3; z > -9e-3; z -= 1e-6) {
    const double now_N = hand.tick({3.1e-3, 1.4e-3, z}).norm();
    steepest_N_m = std::max(steepest_N_m, std::abs(now_N - before_N) / 1e-6);
    softest = std::min(softest, share_of(hand));
    before_N = now_N;
  }
  EXPECT_LT(softest, 0.9);
  Tool whole(loaded.asset);
  double stiffness_N_m = 0;
  for (double z = 1e-3; z > -9e-3; z -= 1e-5) {
    const double was_N = Vec3::Map(whole.out.force_on_tool_N).norm();
    stiffness_N_m =
        std::max(stiffness_N_m, (whole.tick({3.1e-3, 1.4e-3, z}).norm() - was_N) / 1e-5);
  }
  // eta' f^2 beside eta f': on its way back to first loading the force is steeper, but does not
  // jump.
  EXPECT_LT(steepest_N_m, 20 * stiffness_N_m);
}

TEST(damage, with_r_below_one_a_dent_stays) {
  const Loaded loaded = load(softening(plate(), {0.6, 0.02, 0.15, 0.012}));
  DamagedBody body(loaded.asset);
  Tool hand(body.view);
  for (double z = 1e-3; z > -4e-3; z -= 2e-5) hand.tick({1e-3, 0.7e-3, z});
  for (double z = -4e-3; z < 1e-3; z += 2e-5) hand.tick({1e-3, 0.7e-3, z});
  double touched_m = 0;
  for (double z = 1e-3; z > -4e-3; z -= 2e-5)
    if (hand.tick({1e-3, 0.7e-3, z}).norm() > 0 && touched_m == 0) touched_m = -z;
  EXPECT_GT(touched_m, 1e-3);
  EXPECT_LT(touched_m, 4e-3);
}

TEST(damage, an_asset_without_it_has_the_bytes_of_one_that_knows_none) {
  Model model = softening(plate());
  const AssetBytes with = make_asset_bytes(model, {});
  model.curves.damage = {};
  const AssetBytes without = make_asset_bytes(model, {});
  EXPECT_EQ(with.size(), without.size() + sizeof(runtime::DamageBlock));
  runtime::Header header;
  std::memcpy(&header, without.data(), sizeof header);
  EXPECT_EQ(header.flags & runtime::DamageBlock::kFlag, 0u);
}

TEST(damage, a_saved_body_goes_on_with_the_same_bits_and_bytes_that_are_none_are_refused) {
  const Loaded loaded = load(softening(plate()));
  DamagedBody body(loaded.asset);
  Tool hand(body.view);
  for (double z = 1e-3; z > -4e-3; z -= 1e-4) hand.tick({1e-3, 0.7e-3, z});
  const std::vector<std::uint64_t> saved = body.memory;
  const Contact kept = hand.contact;
  const Vec3 first = hand.tick({2e-3, 0.7e-3, -6e-3});
  EXPECT_NE(body.memory, saved);
  body.memory = saved;
  ASSERT_TRUE(runtime::is_body(loaded.asset, body.memory.data(), 8 * saved.size()));
  hand.contact = kept;
  EXPECT_EQ(hand.tick({2e-3, 0.7e-3, -6e-3}), first);

  const auto refused = [&](std::vector<std::uint64_t> bytes) {
    return !runtime::is_body(loaded.asset, bytes.data(), 8 * bytes.size());
  };
  EXPECT_TRUE(refused({saved.begin(), saved.end() - 1}));
  for (const std::size_t word : {0, 1, 2, 3, 8, 20}) {
    std::vector<std::uint64_t> broken = saved;
    broken[word] ^= 0xff800000ff800000u;
    EXPECT_TRUE(refused(broken)) << word;
  }
  const Loaded other = load(softening(plate(), {1.5, 0.02, 0.15, 0.012}));
  EXPECT_FALSE(runtime::is_body(other.asset, saved.data(), 8 * saved.size()));
}

TEST(damage, the_tangent_is_the_slope_of_what_a_tick_answers) {
  const Loaded loaded = load(softening(plate()));
  DamagedBody body(loaded.asset);
  Tool hand(body.view);
  for (double z = 1e-4; z > -6e-3; z -= 1e-4) hand.tick({0, 0.7e-3, z});
  for (double z = -6e-3; z < 2e-4; z += 1e-4) hand.tick({0, 0.7e-3, z});
  hand.tick({0, 0.7e-3, 1e-4});
  int checked = 0;
  for (int i = 1; i <= 90; ++i) {
    const Vec3 x(1e-5 * std::max(0, i - 40), 0.7e-3 + 3e-6 * std::max(0, i - 70),
                 -1e-4 * std::min(i, 40));
    const Contact before = hand.contact;
    const std::vector<std::uint64_t> saved = body.memory;
    const auto tick = [&](const Vec3& at, double* tangent) {
      body.memory = saved;
      hand.contact = before;
      touch(body.view, hand.contact, at.data(), hand.out, tangent);
      return Vec3(-Vec3::Map(hand.out.force_on_tool_N));
    };
    tick(x, nullptr);
    EXPECT_LT(share_of(hand), 1);
    // Where something slips, the share of the force is differentiated as if it stuck.
    const double lost_J = hand.contact.ledger.dissipated_J - before.ledger.dissipated_J;
    if (i > 1 && hand.out.state == ContactState::stick &&
        std::abs(lost_J) < 1e-12 * hand.out.stored_J)
      checked += expect_tangent_is_slope(tick, x);
    tick(x, nullptr);
  }
  EXPECT_GT(checked, 100);
}

TEST(damage, numbers_that_damage_cannot_follow_are_refused) {
  const Model model = softening(plate());
  for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(), 1e9})
    for (const int number : {0, 3, 5}) {
      if (number > 0 && bad == 0) continue;  // no reach is one
      AssetBytes bytes = make_asset_bytes(model, {});
      std::memcpy(bytes.data() + bytes.size() - sizeof(runtime::DamageBlock) + 8 * number, &bad, 8);
      fix_checksum(bytes, bytes.size());
      EXPECT_EQ(open(bytes, bytes.size()), Status::block_wrong) << bad << " at " << number;
    }
}

TEST(damage, the_c_interface_starts_opens_and_ticks_a_body) {
  const Loaded loaded = load(softening(plate()));
  palpate_asset asset, body;
  ASSERT_EQ(palpate_open(&asset, loaded.bytes.data(), loaded.bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.softens, 1);
  std::vector<std::uint64_t> memory(palpate_body_bytes(&asset) / 8);
  ASSERT_FALSE(memory.empty());
  const std::uint64_t size = 8 * memory.size();
  EXPECT_EQ(palpate_body_open(&body, &asset, memory.data(), size), PALPATE_BODY_WRONG);
  EXPECT_EQ(palpate_body_start(&asset, memory.data(), size - 8), PALPATE_BODY_WRONG);
  EXPECT_EQ(palpate_body_start(&asset, nullptr, size), PALPATE_NULL_ARGUMENT);
  ASSERT_EQ(palpate_body_start(&asset, memory.data(), size), PALPATE_OK);
  ASSERT_EQ(palpate_body_open(&body, &asset, memory.data(), size), PALPATE_OK);
  palpate_contact contact;
  const palpate_tool tool = palpate_tip();
  palpate_start(&contact, &tool);
  palpate_output out;
  double way_in_N = 0;
  for (int k = -10; k <= 70; ++k) {
    const palpate_input in = palpate_input_at(1e-3, 7e-4, -1e-4 * (k <= 40 ? k : 80 - k), 0.001);
    ASSERT_EQ(palpate_tick(&body, &contact, 1, &in, &out), PALPATE_OK);
    if (k == 20) way_in_N = out.force_on_tool_N[2];
    if (k == 60) {
      EXPECT_LT(out.force_on_tool_N[2], 0.7 * way_in_N);
    }
  }
  const Loaded plain = load(softening(plate(), {}));
  palpate_open(&asset, plain.bytes.data(), plain.bytes.size());
  EXPECT_EQ(palpate_body_bytes(&asset), 0u);
  EXPECT_STREQ(palpate_sentence(PALPATE_BODY_WRONG),
               "The bytes are no body of this asset, or nothing damages its bodies.");
}

}  // namespace
}  // namespace palpate::test
