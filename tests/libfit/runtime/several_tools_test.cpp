// Several tools that feel each other (docs/method-tools.md, section 28): forces are derivatives of
// what all store together, and nothing is created. Failures print the seed.

#include "libfit/runtime/series/tick.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/runtime/palpate.h"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

using runtime::BallTick;
using runtime::Coupling;
using runtime::CouplingView;
using runtime::TogetherMemory;

constexpr double kRadius_m = 0.004;

CouplingView coupling(double give_m_N, double across_m_N = 0) {
  CouplingView out;
  out.length_m = 0.003;
  for (int k = 0; k < 3; ++k) {
    out.give_m_N[k] = give_m_N / 3;
    out.across_m_N[k] = across_m_N / 3;
  }
  return out;
}

Model rings_model(bool is_round, double friction, double slope = 0) {
  Model model = is_round ? sphere_model(0.03, 24, uniform(400, 300, 0.3))
                         : plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_rings(model, friction, is_round ? 0.03 : 0, [&](const Vec3& x) { return 1 + slope * x[0]; });
  return model;
}

// The same on a body that sways, more at +x.
Model swaying_model(bool is_round, double friction, double slope = 0) {
  Model model = rings_model(is_round, friction, slope);
  auto& sway = model.curves.control[runtime::kSway];
  for (Eigen::Index v = 0; v < sway.rows(); ++v) {
    const double more = 1 + 5 * model.surface.vertices(v, 0);
    sway.row(v) << 0.012 * more, 0.02, 0.004, 0.003, -0.001 * more, 0.002;
  }
  sway = rounded_to_float(sway);
  return model;
}

struct Hands {
  Loaded loaded;
  runtime::AssetView asset;
  CouplingView feel;
  std::vector<Contact> contact;
  std::vector<BallTick> tool;
  TogetherMemory joint;

  Hands(const Model& model, const CouplingView& of, std::size_t count)
      : loaded(load(model)), asset(loaded.asset), feel(of), contact(count), tool(count) {
    asset.coupling = &feel;
  }
  Hands(const Hands&) = delete;

  void tick(const std::vector<Vec3>& centre) {
    for (std::size_t i = 0; i < tool.size(); ++i) {
      tool[i].contact = &contact[i];
      tool[i].radius_m = kRadius_m;
      tool[i].tool = static_cast<int>(i);
      Eigen::Map<Vec3>(tool[i].place_m) = centre[i];
    }
    touch_together(asset, joint, tool.data(), static_cast<int>(tool.size()));
  }
  void go(const std::vector<Vec3>& to, int ticks) {
    std::vector<Vec3> from, at = to;
    for (const BallTick& t : tool) from.push_back(Eigen::Map<const Vec3>(t.place_m));
    for (int k = 1; k <= ticks; ++k) {
      for (std::size_t i = 0; i < to.size(); ++i) at[i] = from[i] + (to[i] - from[i]) * k / ticks;
      tick(at);
    }
  }
  double stored_J() const {
    double sum = 0;
    for (const BallTick& t : tool) sum += t.out.stored_J;
    return sum;
  }
  Vec3 force(std::size_t i) const { return -Eigen::Map<const Vec3>(tool[i].out.force_on_tool_N); }

  /// The state after another tick, which is undone.
  template <class Read>
  auto after(const std::vector<Vec3>& centre, const Read& read) {
    const auto contacts = contact;
    const auto tools = tool;
    const TogetherMemory before = joint;
    tick(centre);
    const auto out = read();
    contact = contacts;
    tool = tools;
    joint = before;
    return out;
  }
};

std::vector<Vec3> places(bool is_round, double depth_m) {
  std::vector<Vec3> out;
  for (const Vec3& way : {Vec3(-0.5, 0.1, 1), Vec3(0.35, 0.12, 1), Vec3(0.05, -0.4, 1)}) {
    const Vec3 u = way.normalized();
    out.push_back(is_round ? Vec3((0.03 + kRadius_m - depth_m) * u)
                           : Vec3(0.03 * u.x(), 0.03 * u.y(), kRadius_m - depth_m));
  }
  return out;
}

// Three that stick: forces by differences of what all store.
void expect_gradient(const Model& model, bool is_round, double tolerance) {
  Hands hands(model, coupling(0.004, 0.003), 3);
  hands.tick(places(is_round, -0.0005));
  std::vector<Vec3> at = places(is_round, 0.003);
  for (std::size_t i = 0; i < 3; ++i) at[i] += 1e-4 * Vec3(1, double(i), -0.5);
  hands.go(at, 300);
  for (std::size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      constexpr double h = 1e-7;
      auto plus = at, minus = at;
      plus[i][k] += h;
      minus[i][k] -= h;
      const auto stored = [&] { return hands.stored_J(); };
      const double slope = (hands.after(plus, stored) - hands.after(minus, stored)) / (2 * h);
      EXPECT_NEAR(hands.force(i)[k], slope, tolerance * hands.force(i).norm()) << i << " " << k;
    }
  EXPECT_GT(hands.force(0).norm(), 0.02);
}

TEST(SeveralTools, forces_are_the_gradient_of_what_all_store_while_all_stick) {
  for (const bool is_round : {false, true})
    expect_gradient(rings_model(is_round, 300, 5), is_round, 2e-5);
}

TEST(SeveralTools, forces_are_that_gradient_on_a_body_that_sways) {
  for (const bool is_round : {false, true})
    expect_gradient(swaying_model(is_round, 300, 5), is_round, 5e-5);
}

TEST(SeveralTools, on_a_body_that_sways_one_is_a_tool_and_two_sway_together) {
  Hands hands(swaying_model(false, 1), coupling(1e-7), 2);
  Contact alone;
  Output out;
  std::vector<Vec3> at{{-0.02, 0, kRadius_m + 5e-4}, {0.02, 0, kRadius_m + 0.01}};
  for (int i = 0; i < 300; ++i) {
    at[0].z() -= 1e-5;
    hands.tick(at);
    runtime::touch_ball(hands.asset, alone, at[0].data(), kRadius_m, out);
    EXPECT_LT((hands.force(0) + Vec3::Map(out.force_on_tool_N)).norm(), 1e-6);
    EXPECT_NEAR(hands.stored_J(), out.stored_J, 1e-10);
  }
  const double before_N = hands.force(0).norm();
  at[1].z() = kRadius_m - 0.002;  // 40 mm away: what it pushes away goes from under the first, too
  hands.go(at, 600);
  EXPECT_GT(hands.force(1).norm(), 0.01);
  EXPECT_LT(hands.force(0).norm(), 0.97 * before_N);
}

TEST(SeveralTools, what_one_does_to_another_is_mutual) {
  Hands hands(rings_model(true, 300, 5), coupling(0.004, 0.003), 3);
  hands.tick(places(true, -0.0005));
  const auto at = places(true, 0.003);
  hands.go(at, 300);
  constexpr double h = 1e-6;
  const auto by = [&](std::size_t i, std::size_t j) {  // d f_i / d x_j
    Mat3 out;
    for (int k = 0; k < 3; ++k) {
      auto plus = at, minus = at;
      plus[j][k] += h;
      minus[j][k] -= h;
      const auto force = [&] { return hands.force(i); };
      out.col(k) = (hands.after(plus, force) - hands.after(minus, force)) / (2 * h);
    }
    return out;
  };
  const Mat3 there = by(0, 1), back = by(1, 0);
  EXPECT_GT(there.norm(), 0.1);
  EXPECT_LT((there - back.transpose()).norm(), 1e-3 * there.norm());
}

TEST(SeveralTools, straight_presses_meet_the_surface_where_the_others_have_brought_it) {
  // f_i = F(d_i - c f_j), F = 12 d + 4500 d^2, solved here by bisection.
  const CouplingView feel = coupling(0.005);
  Hands hands(rings_model(false, 1), feel, 2);
  const double r = 0.012, d[2] = {0.003, 0.002};
  const std::vector<Vec3> away{{-r / 2, 0, kRadius_m + 5e-4}, {r / 2, 0, kRadius_m + 5e-4}},
      down{{-r / 2, 0, kRadius_m - d[0]}, {r / 2, 0, kRadius_m - d[1]}};
  hands.tick(away);
  hands.go(down, 400);
  const double c = runtime::coupling_at(feel, r * r).give;
  const auto F = [](double x) { return x > 0 ? 12 * x + 4500 * x * x : 0; };
  double low = 0, high = F(d[0]);
  for (int k = 0; k < 100; ++k) {
    const double f = (low + high) / 2;
    (F(d[0] - c * F(d[1] - c * f)) > f ? low : high) = f;
  }
  EXPECT_NEAR(-hands.force(0).z(), low, 1e-6 * low);
  EXPECT_NEAR(-hands.force(1).z(), F(d[1] - c * low), 1e-6 * low);
  EXPECT_LT(low, 0.995 * F(d[0]));
}

TEST(SeveralTools, a_tool_that_comes_touches_the_surface_in_the_dent) {
  Hands hands(rings_model(false, 1), coupling(0.006), 2);
  const double r = 0.009;
  std::vector<Vec3> at{{-r / 2, 0, kRadius_m + 5e-4}, {r / 2, 0, kRadius_m + 5e-4}};
  hands.tick(at);
  at[0].z() = kRadius_m - 0.004;
  hands.go(at, 400);
  const double alone_N = -hands.force(0).z();
  const double sunk_m = runtime::coupling_at(hands.feel, r * r).give * alone_N;
  ASSERT_GT(sunk_m, 1e-4);
  at[1].z() = kRadius_m - 0.97 * sunk_m;
  hands.go(at, 200);
  EXPECT_EQ(hands.force(1).norm(), 0);
  EXPECT_EQ(-hands.force(0).z(), alone_N);
  at[1].z() = kRadius_m - 1.05 * sunk_m;
  hands.go(at, 20);
  EXPECT_GT(hands.force(1).norm(), 0);
  // It stays in touch with the surface that comes back.
  at[0].z() = kRadius_m + 5e-4;
  hands.go(at, 400);
  EXPECT_EQ(hands.force(0).norm(), 0);
  EXPECT_NEAR(-hands.force(1).z(), 12 * 1.05 * sunk_m + 4500 * std::pow(1.05 * sunk_m, 2), 1e-9);
}

TEST(SeveralTools, one_tool_in_a_group_is_a_tool) {
  Hands hands(rings_model(true, 1, 10), coupling(0.004, 0.002), 2);
  Contact alone;
  Output out;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  Vec3 at(0.001, 0.002, 0.0345);
  const Vec3 far(0, 0, -0.05);
  for (int i = 0; i < 600; ++i) {
    hands.tick({at, far});
    runtime::touch_ball(hands.asset, alone, at.data(), kRadius_m, out);
    EXPECT_LT((hands.force(0) + Vec3::Map(out.force_on_tool_N)).norm(), 1e-12) << i;
    EXPECT_NEAR(hands.stored_J(), out.stored_J, 1e-15);
    at += Vec3(8e-5 * share(random), 8e-5 * share(random), i < 100 ? -3e-5 : 2e-5 * share(random));
  }
  EXPECT_GT(hands.force(0).norm(), 0.02);
}

TEST(SeveralTools, without_coupling_each_is_by_itself_bit_for_bit) {
  Hands hands(rings_model(true, 1, 10), {}, 2);
  hands.asset.coupling = nullptr;
  Contact alone[2];
  Output out[2];
  for (int i = 0; i < 300; ++i) {
    const std::vector<Vec3> at{{0.008 + 1e-5 * i, 0, 0.034 - 2e-5 * i},
                               {-0.008, 0, 0.034 - 1e-5 * i}};
    hands.tick(at);
    for (std::size_t k = 0; k < 2; ++k) {
      runtime::touch_ball(hands.asset, alone[k], at[k].data(), kRadius_m, out[k]);
      EXPECT_EQ(0, std::memcmp(&out[k], &hands.tool[k].out, sizeof(double) * 3));
      EXPECT_EQ(out[k].stored_J, hands.tool[k].out.stored_J);
    }
  }
}

TEST(SeveralTools, in_one_place_bear_more_than_one_and_say_so) {
  Model model = rings_model(false, 1);
  Hands one(model, coupling(0.004), 1), four(model, coupling(0.004), 4);
  const Vec3 away(0, 0, kRadius_m + 5e-4), down(0, 0, kRadius_m - 0.003);
  one.tick({away});
  one.go({down}, 300);
  four.tick({away, away, away, away});
  four.go({down, down, down, down}, 300);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NE(four.tool[i].out.flags & runtime::kFlagCrowded, 0u);
    EXPECT_EQ(four.tool[i].out.flags & runtime::kFlagUnfinished, 0u);
    EXPECT_LT(four.force(i).norm(), one.force(0).norm());
    sum += four.force(i).norm();
  }
  EXPECT_GT(sum, one.force(0).norm());
  EXPECT_EQ(one.tool[0].out.flags & runtime::kFlagCrowded, 0u);
}

TEST(SeveralTools, closed_ways_of_four_create_nothing) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const bool is_round = seed % 2 == 0;
    const double friction = seed % 3 == 0 ? 0.02 : 1;
    Hands hands(
        seed > 4 ? swaying_model(is_round, friction, 20) : rings_model(is_round, friction, 20),
        coupling(0.004, 0.003), 4);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    const double top = is_round ? 0.03 : 0;
    std::vector<Vec3> home;
    for (int i = 0; i < 4; ++i)
      home.emplace_back(i % 2 ? 0.006 : -0.006, i < 2 ? 0.006 : -0.006, top + kRadius_m + 5e-4);
    hands.tick(home);
    std::vector<Vec3> at = home, force(4, Vec3::Zero());
    double work_J = 0, in_J = 0, lost_J = 0;
    const auto move = [&](const std::vector<Vec3>& to, int ticks) {
      const auto from = at;
      for (int k = 1; k <= ticks; ++k) {
        const auto before = at;
        for (std::size_t i = 0; i < 4; ++i) at[i] = from[i] + (to[i] - from[i]) * k / ticks;
        hands.tick(at);
        double work = 0;
        for (std::size_t i = 0; i < 4; ++i) {
          work += 0.5 * (force[i] + hands.force(i)).dot(at[i] - before[i]);
          force[i] = hands.force(i);
        }
        work_J += work;
        in_J += std::max(work, 0.0);
        const double lost = hands.joint.ledger.dissipated_J - hands.joint.ledger.tank_J;
        EXPECT_GE(lost, lost_J - 1e-12 * in_J) << "seed " << seed;
        lost_J = lost;
        EXPECT_GE(hands.stored_J(), 0) << "seed " << seed;
      }
    };
    for (int leg = 0; leg < 6; ++leg) {
      std::vector<Vec3> to = home;
      for (Vec3& x : to)
        x += Vec3(0.004 * share(random), 0.004 * share(random), -0.0025 + 0.0025 * share(random));
      move(to, 600);
    }
    auto up = at;
    for (Vec3& x : up) x.z() += 0.01;
    move(up, 1200);
    EXPECT_EQ(hands.stored_J(), 0) << "seed " << seed;
    EXPECT_GT(in_J, 1e-6);
    EXPECT_GT(work_J, -2e-3 * in_J) << "seed " << seed;  // of the trapezoids
  }
}

TEST(SeveralTools, a_tool_that_is_refused_leaves_the_others) {
  Hands hands(rings_model(false, 1), coupling(0.004), 2);
  std::vector<Vec3> at{{-0.006, 0, kRadius_m + 5e-4}, {0.006, 0, kRadius_m + 5e-4}};
  hands.tick(at);
  for (Vec3& x : at) x.z() = kRadius_m - 0.002;
  hands.go(at, 200);
  const double stored_J = hands.stored_J();
  at[1].x() = std::numeric_limits<double>::quiet_NaN();
  hands.tick(at);
  EXPECT_EQ(hands.tool[1].status, Status::tip_not_finite);
  EXPECT_EQ(hands.force(1).norm(), 0);
  EXPECT_EQ(hands.tool[0].status, Status::ok);
  EXPECT_NEAR(-hands.force(0).z(), 12 * 0.002 + 4500 * 0.002 * 0.002, 1e-9);
  EXPECT_LT(hands.stored_J(), stored_J);
}

TEST(SeveralTools, an_asset_says_how_they_feel_each_other) {
  Model model = rings_model(false, 1);
  const AssetBytes plain = make_asset_bytes(model, {});
  model.curves.coupling = coupling(0.004, 0.002);
  const AssetBytes bytes = make_asset_bytes(model, {});
  EXPECT_EQ(bytes.size(), plain.size() + sizeof(runtime::CouplingBlock));
  Status status;
  const auto asset = Asset::open(bytes.data(), bytes.size(), &status);
  ASSERT_EQ(status, Status::ok);
  ASSERT_NE(asset.coupling, nullptr);
  EXPECT_EQ(0, std::memcmp(asset.coupling, &model.curves.coupling, sizeof(CouplingView)));
  EXPECT_EQ(Asset::open(plain.data(), plain.size(), &status).coupling, nullptr);
  // Softer than the contacts themselves the joint energy need not be convex: they bear a share.
  model.curves.coupling = coupling(0.012);
  const AssetBytes strong = make_asset_bytes(model, {});
  const auto soft = Asset::open(strong.data(), strong.size(), &status);
  ASSERT_EQ(status, Status::ok);
  const double middle[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  int shared = 0;
  for (int t = 0; t < soft.triangles; ++t) {
    const runtime::ContactStiffness k = runtime::stiffness_at_end(soft, t, middle);
    const double share = runtime::coupling_share(soft, *soft.coupling, t, middle);
    const double borne =
        share * share * runtime::coupling_excess(*soft.coupling, k.along_N_m, k.across_N_m);
    EXPECT_LE(borne, 1 + 1e-12);
    EXPECT_TRUE(share == 1 || std::abs(borne - 1) < 1e-12) << borne;
    shared += share < 1;
    EXPECT_EQ(runtime::coupling_share(asset, *asset.coupling, t, middle), 1);
  }
  EXPECT_GT(shared, 0);
  model.curves.coupling = coupling(-0.001);
  EXPECT_THROW(make_asset_bytes(model, {}), Error);
}

TEST(SeveralTools, in_c_are_the_same) {
  Model model = rings_model(false, 1);
  model.curves.coupling = coupling(0.004, 0.002);
  const AssetBytes bytes = make_asset_bytes(model, {});
  palpate_asset asset;
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.couples, 1);
  const palpate_tool ball = palpate_ball(kRadius_m);
  std::vector<palpate_contact> contacts(9);
  palpate_start(&contacts[0], &ball);
  palpate_input in[9];
  palpate_output out[9];
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_NOT_STARTED);
  palpate_start(&contacts[1], &ball);
  Hands hands(model, model.curves.coupling, 2);
  for (int k = 0; k < 200; ++k) {
    const double z = kRadius_m + 5e-4 - 2e-5 * k;
    in[0] = palpate_input_at(-0.006 + 2.5e-5 * k, 0, z);
    in[1] = palpate_input_at(0.006, 1e-5 * k, z);
    ASSERT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_OK);
    hands.tick({{-0.006 + 2.5e-5 * k, 0, z}, {0.006, 1e-5 * k, z}});
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_EQ(0, std::memcmp(out[i].force_on_tool_N, hands.tool[i].out.force_on_tool_N, 24));
  }
  EXPECT_GT(out[0].force_on_tool_N[2], 0.05);
  in[1].tool.orientation[0] = 0;
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_POSE_WRONG);
  EXPECT_EQ(out[0].status, PALPATE_OK);
  EXPECT_EQ(out[1].force_on_tool_N[2], 0);
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 9, in, out), PALPATE_COUNT_WRONG);
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 0, in, out), PALPATE_COUNT_WRONG);
  palpate_tool five = ball;
  five.balls = 5;
  for (double& radius_m : five.radius_m) radius_m = kRadius_m;
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(palpate_start(&contacts[i], &five), PALPATE_OK);
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_COUNT_WRONG);
  EXPECT_NE(std::string(palpate_sentence(PALPATE_COUNT_WRONG)), "Unknown status.");
}

// A tool that presses at 10 Hz beside a damped one that goes along with the dent by a few percent:
// what the damper took was the work of the surface's own motion, and cycles yielded energy for
// ever.
TEST(SeveralTools, beside_one_that_presses_a_damper_takes_what_it_says) {
  for (const double along : {0.02, 0.08}) {
    Loaded loaded = load(rings_model(false, 1));
    const CouplingView feel = coupling(0.006);
    loaded.asset.coupling = &feel;
    runtime::Tool tool[2];
    for (runtime::Tool& t : tool) t.shape.ball[0].radius_m = kRadius_m;
    tool[1].shape.damping_Ns_m = 100;
    tool[1].shape.damper_depth_m = 1e-4;
    runtime::Tool* const tools[2] = {&tool[0], &tool[1]};
    double work_J = 0, before_z[2] = {}, before_N[2] = {};
    constexpr int kTicks = 400;
    for (int k = 0; k <= 20 * kTicks; ++k) {
      const double press_m = 0.002 * (1 - std::cos(2 * M_PI * k / kTicks)) - 1e-4;
      const double z[2] = {kRadius_m - press_m, kRadius_m - 0.001 - along * press_m};
      runtime::ToolInput in[2];
      runtime::ToolOutput out[2];
      Status status[2];
      for (int i = 0; i < 2; ++i) {
        in[i].pose.position_m[0] = 0.01 * i;
        in[i].pose.position_m[2] = k == 0 ? kRadius_m + 1e-3 : z[i];
        in[i].dt_s = 2.5e-4;
      }
      touch_tools(loaded.asset, tools, in, out, status, 2);
      for (int i = 0; i < 2; ++i) {
        ASSERT_EQ(status[i], Status::ok);
        const double now_z = in[i].pose.position_m[2], now_N = out[i].force_on_tool_N[2];
        if (k > kTicks) work_J -= 0.5 * (before_N[i] + now_N) * (now_z - before_z[i]);
        before_z[i] = now_z;
        before_N[i] = now_N;
      }
    }
    EXPECT_GT(work_J, 0) << "19 cycles, going along by " << along;
    EXPECT_GT(tool[1].damped_J, 0);
  }
}

}  // namespace
}  // namespace palpate::test
