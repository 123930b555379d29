// Awkward states in any order on awkward bodies: finite, bounded, flagged. Failures print the seed.

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kSteepest_N_m = 900;  // no curve below is steeper, nor do two together add more

struct AwkwardBody {
  Loaded body;
  bool is_frictionless, has_no_lateral;
};

// A plate or a sphere, frictionless or without lateral stiffness or neither, whose surface has
// triangles without area, folded over and not covered.
AwkwardBody awkward_body(std::mt19937& random, unsigned seed) {
  const bool is_frictionless = seed % 3 == 0, has_no_lateral = seed % 3 == 1;
  const auto curves =
      uniform(400, has_no_lateral ? 0 : 300, is_frictionless ? 0 : 0.1 * double(seed % 5));
  Model model = seed % 2 == 0 ? plate_model(0.08, 12, curves) : sphere_model(0.03, 12, curves);
  std::uniform_int_distribution<Eigen::Index> any(0, model.surface.triangles.rows() - 1);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Index flat = any(random), folded = any(random), bare = any(random);
    const auto corner = [&](Eigen::Index t, int k) { return model.surface.triangles(t, k); };
    model.surface.vertices.row(corner(flat, 0)) = model.surface.vertices.row(corner(flat, 1));
    model.inward_normal.row(corner(folded, 2)) *= -1;
    const int node = corner(bare, 1);
    model.is_covered[static_cast<std::size_t>(node)] = 0;
    for (Controls& control : model.curves.control) control.row(node).setZero();
  }
  return {load(model), is_frictionless, has_no_lateral};
}

struct Walker {
  const AwkwardBody& subject;
  std::mt19937& random;
  Tool tool;
  Vec3 x = Vec3(0, 0, 0.05), goal = x;
  double before_J = 0;        // dissipated but what friction has laid by
  std::array<int, 5> seen{};  // not finite, teleported, inside, vertex, frictionless

  double draw() { return std::uniform_real_distribution<double>(-1, 1)(random); }
  void expect_silence() {
    for (double f : tool.out.force_on_tool_N) ASSERT_EQ(f, 0);
    ASSERT_EQ(tool.out.state, ContactState::air);
  }
  void expect_sense() {
    const Output& out = tool.out;
    const Vec3 f = Vec3::Map(out.force_on_tool_N);
    ASSERT_TRUE(f.allFinite());
    ASSERT_LE(f.norm(), kSteepest_N_m * (std::max(out.normal_m, 0.0) + out.lateral_m) + 1e-12);
    const double lost_J = out.dissipated_J - tool.contact.ledger.tank_J;
    ASSERT_GE(lost_J, before_J * (1 - 1e-12) - 1e-15);
    before_J = lost_J;
    if (out.state == ContactState::air) return expect_silence();
    ASSERT_NEAR(out.weight[0] + out.weight[1] + out.weight[2], 1, 1e-12);
    const bool is_deep = out.normal_m > double(subject.body.asset.max_depth_m[out.triangle]);
    ASSERT_EQ((out.flags & PALPATE_FLAG_TOO_DEEP) != 0, is_deep);
    if (subject.has_no_lateral) {
      ASSERT_TRUE(out.flags & PALPATE_FLAG_FRICTIONLESS);
      ++seen[4];
    }
  }

  void not_finite() {
    const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity()};
    Vec3 at = x;
    at[static_cast<int>(random() % 3)] = bad[random() % 3];
    tool.tick(at);
    ASSERT_EQ(tool.status, Status::tip_not_finite);
    expect_silence();
    ++seen[0];
  }
  void teleport() {
    tool.tick(x);  // a tick after NaN only learns where the tip is
    x += Vec3(draw(), draw(), draw()).normalized() * std::pow(10.0, 1 + 10 * std::abs(draw()));
    tool.tick(x);
    ASSERT_EQ(tool.status, Status::tip_teleported);
    expect_silence();
    x = goal = Vec3(0, 0, 0.05);
    tool.contact.has_tip = false;
    ++seen[1];
  }
  void start_inside() {
    tool.contact = Contact();
    before_J = 0;
    x = goal = Vec3(0.002 * draw(), 0.002 * draw(), -0.01);
    tool.tick(x);
    ASSERT_EQ(tool.status, Status::ok);
    expect_silence();
    ++seen[2];
  }
  void aim_at_a_vertex() {  // to the bit, from outside and to below it
    const Asset& asset = subject.body.asset;
    const int v = static_cast<int>(random() % static_cast<unsigned>(asset.vertices));
    const auto place = asset.vertex_at(v), u = asset.normal_at(v);
    const Vec3 at(place.x + asset.origin_m[0], place.y + asset.origin_m[1],
                  place.z + asset.origin_m[2]),
        inward(u.x, u.y, u.z);
    x = goal = at - 0.004 * inward;
    tool.contact = Contact();
    before_J = 0;
    for (const Vec3& stop : {x, at, Vec3(at + 0.002 * inward)}) {
      tool.tick(x = goal = stop);
      ASSERT_EQ(tool.status, Status::ok);
      expect_sense();
    }
    ++seen[3];
  }
};

TEST(awkward, states_in_any_order_stay_finite_bounded_and_flagged) {
  std::array<int, 5> seen{};
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const AwkwardBody subject = awkward_body(random, seed);
    Walker walker{subject, random, Tool(subject.body.asset, seed % 4 < 2 ? 0 : 0.002)};
    for (int tick = 0; tick < 4000 && !testing::Test::HasFatalFailure(); ++tick) {
      switch (random() % 200) {
        case 0:
          walker.not_finite();
          break;
        case 1:
          walker.teleport();
          break;
        case 2:
          walker.start_inside();
          break;
        case 3:
        case 4:
          walker.aim_at_a_vertex();
          break;
        case 5:
          walker.goal = Vec3(0.03 * walker.draw(), 0.03 * walker.draw(), 0.04 * walker.draw());
          break;
        default:
          walker.x += (walker.goal - walker.x) * 0.05;
          walker.tool.tick(walker.x);
          ASSERT_EQ(walker.tool.status, Status::ok) << "tick " << tick;
          walker.expect_sense();
      }
    }
    if (testing::Test::HasFatalFailure()) return;
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] += walker.seen[i];
  }
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_GT(seen[i], 200) << "state " << i;
}

}  // namespace
}  // namespace palpate::test
