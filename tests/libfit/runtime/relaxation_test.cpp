// A body that relaxes (docs/method-body.md, section 24), in the engine.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libfit/runtime/series/quadric_replay.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kTick_s = 1e-3;

Relaxation two_branches() {
  Relaxation out;
  out.share = Eigen::Vector2d(0.5, 0.8);
  out.time_s = Eigen::Vector2d(0.05, 0.6);
  return out;
}

Model relaxing(Model model, double friction, double radius_m,
               const std::function<double(const Vec3&)>& scale, const Relaxation& relaxation,
               const std::function<Vec3(const Vec3&)>& side = nullptr) {
  make_rings(model, friction, radius_m, scale, side);
  model.curves.relaxation = relaxation;
  model.curves.control[runtime::kSpread].setZero();
  return model;
}

TEST(relaxation, a_pressed_plate_relaxes_to_slow_motion) {
  const Loaded fast = load(relaxing(plate(), 1, 0, even, two_branches()));
  const Loaded slow = load(relaxing(plate(), 1, 0, even, {}));
  Tool tool(fast.asset, 0, kTick_s), still(slow.asset, 0, kTick_s);
  tool.tick({0, 0, 1e-4});
  still.tick({0, 0, 1e-4});
  const Vec3 deep(0, 0, -6e-3);
  tool.dt_s = 1e-5;
  const double slow_N = still.tick(deep).norm(), first_N = tool.tick(deep).norm();
  tool.dt_s = kTick_s;
  EXPECT_NEAR(first_N / slow_N, 2.3, 0.01);
  double t = 1e-5;
  for (int i = 0; i < 6000; ++i) {
    const double force_N = tool.tick(deep).norm();
    t += kTick_s;
    ASSERT_NEAR(force_N / slow_N, 1 + 0.5 * std::exp(-t / 0.05) + 0.8 * std::exp(-t / 0.6), 0.01);
  }
  EXPECT_NEAR(tool.out.stored_J, still.out.stored_J, 0.01 * still.out.stored_J);
  EXPECT_GT(tool.out.dissipated_J, 0);
}

// One tick of a fit's replay is one of the engine.
TEST(relaxation, the_fitter_replays_what_the_engine_answers) {
  const Model model = relaxing(plate(), 1, 0, even, two_branches());
  const Loaded loaded = load(model);
  Tool tool(loaded.asset, 0, kTick_s);
  const Vec3 start(1.1e-3, 0.7e-3, 0);  // off the edges
  tool.tick(start + Vec3(0, 0, 1e-8));
  std::vector<double> way, time_s;
  std::vector<Vec3> answers;
  for (int i = 1; i <= 3000; ++i) {
    const double t = i / 1000.0;
    const double aside = std::max(0.0, t - 0.1);
    const Vec3 x(4e-3 * std::sin(2 * aside), 3e-3 * (1 - std::cos(3 * aside)),
                 -6e-3 * std::min(t, 1.0));
    way.insert(way.end(), {x[0], x[1], x[2]});
    time_s.push_back(i * kTick_s);
    answers.push_back(tool.tick(start + x));
  }
  const float* node = loaded.asset.node(loaded.asset.corner(tool.contact.triangle, 0));
  std::vector<double> control(static_cast<std::size_t>(loaded.asset.controls_per_vertex));
  runtime::ControlPointers<double> controls{};
  for (std::size_t j = 0; j < control.size(); ++j) control[j] = double(node[j]);
  for (int part = 0; part < runtime::kMaxParts; ++part)
    controls.part[part] = control.data() + loaded.asset.control_offset[part];
  const runtime::Quadric flat{{0, 0, -1}, {}};
  std::vector<runtime::Vec3d> force(answers.size());
  runtime::replay_drag<double>(loaded.asset.curves, controls, flat,
                               {way.data(), static_cast<int>(answers.size()), time_s.data()},
                               nullptr, force.data());
  for (std::size_t i = 0; i < answers.size(); ++i)
    ASSERT_LT((answers[i] - Vec3(force[i].x, force[i].y, force[i].z)).norm(), 1e-9) << "tick " << i;
}

TEST(relaxation, a_time_step_that_is_none_is_refused) {
  const Loaded loaded = load(relaxing(plate(), 1, 0, even, two_branches()));
  for (const double dt_s : {0.0, -1.0, 1e-6, 2e6, std::nan("")}) {
    Tool tool(loaded.asset, 0, kTick_s);
    tool.tick({0, 0, 1e-4});
    EXPECT_GT(tool.tick({0, 0, -1e-3}).norm(), 0);
    tool.dt_s = dt_s;
    EXPECT_EQ(tool.tick({0, 0, -1e-3}).norm(), 0);
    EXPECT_EQ(tool.status, Status::time_step_wrong) << dt_s;
  }
}

TEST(relaxation, without_branches_an_asset_has_the_bytes_of_one_that_knows_no_time) {
  const Model slow = relaxing(plate(), 1, 0, even, {});
  const AssetBytes bytes = make_asset_bytes(slow, {});
  const AssetBytes relaxing_bytes =
      make_asset_bytes(relaxing(plate(), 1, 0, even, two_branches()), {});
  EXPECT_EQ(relaxing_bytes.size(), bytes.size() + sizeof(runtime::RelaxationBlock));
  const Loaded loaded = load(slow);
  Tool with(loaded.asset, 0, kTick_s), without(loaded.asset);
  for (int i = 0; i < 500; ++i) {
    const Vec3 x(1e-5 * i, 0, 1e-4 - 1e-5 * i);
    EXPECT_EQ(with.tick(x), without.tick(x));
  }
}

// Stiffness and side force that change from node to node, friction down to a thousandth, ticks of
// 10 um to 1 cm and 10 us to 10 s.
TEST(relaxation, stored_energy_and_tank_never_rise_without_work) {
  int slid = 0, let_go = 0;
  for (unsigned seed = 1; seed <= 160; ++seed) {
    DrawnRings body(seed);
    const double friction = std::pow(10, -3 * body.unit());
    Relaxation relaxation = two_branches();
    relaxation.share *= std::pow(10, body.unit());
    Model model = body.model(friction);
    model.curves.relaxation = relaxation;
    const Loaded loaded = load(model);
    Tool tool(loaded.asset, 0, kTick_s);
    const Vec3 top(0, 0, body.top_m());
    Vec3 x = top + Vec3(0, 0, 1e-3);
    tool.tick(x);
    const double step_m = std::pow(10, -5 + 3 * body.unit());
    tool.dt_s = std::pow(10, -5 + 6 * body.unit());
    double lost_J = 0, most_J = 0;
    for (int leg = 0; leg < 9; ++leg) {
      const bool lifts = leg % 4 == 3;
      const Vec3 to = leg == 8 ? Vec3(x + Vec3(0, 0, 0.02))
                               : Vec3(top + Vec3(0, 0, lifts ? 1e-3 : -3e-3) +
                                      body.vector(0.004).cwiseProduct(Vec3(1, 1, lifts ? 0 : 0.7)));
      const Vec3 from = x;
      const int ticks = std::clamp(static_cast<int>((to - from).norm() / step_m), 1, 2000);
      for (int k = 1; k <= ticks; ++k) {
        x = from + (to - from) * (double(k) / ticks);
        tool.tick(x);
        ASSERT_EQ(tool.status, Status::ok) << "seed " << seed;
        most_J = std::max(most_J, tool.out.stored_J);
        const double now_J = tool.out.dissipated_J - tool.contact.ledger.tank_J;
        ASSERT_GE(now_J, lost_J - 1e-12 * most_J) << "seed " << seed << " leg " << leg;
        ASSERT_GE(tool.out.stored_J, -1e-18) << "seed " << seed;
        ASSERT_GE(tool.out.stored_J + tool.out.dissipated_J, -1e-12 * most_J) << "seed " << seed;
        lost_J = now_J;
        slid += tool.out.state == ContactState::slip;
      }
    }
    let_go += tool.out.state == ContactState::air;
    EXPECT_GT(most_J, 1e-5) << "seed " << seed;
  }
  EXPECT_GT(slid, 3000);
  EXPECT_EQ(let_go, 160);
}

TEST(relaxation, the_tangent_is_the_slope_of_what_a_tick_answers) {
  const Loaded loaded = load(relaxing(plate(), 1, 0, even, two_branches()));
  Tool tool(loaded.asset, 0, 0.01);
  tool.tick({0, 0.7e-3, 1e-4});  // off the edges
  int slid = 0, checked = 0;
  for (int i = 1; i <= 120; ++i) {
    const Vec3 x(1e-4 * std::max(0, i - 40), 0.7e-3 + 3e-5 * std::max(0, i - 70),
                 -1e-4 * std::min(i, 50));
    const Contact before = tool.contact;
    const auto force = [&](const Vec3& at) {
      Contact contact = before;
      Output out;
      touch(loaded.asset, contact, at.data(), out, nullptr, tool.dt_s);
      return Vec3(-Vec3::Map(out.force_on_tool_N));
    };
    double tangent[9];
    Contact contact = before;
    touch(loaded.asset, contact, x.data(), tool.out, tangent, tool.dt_s);
    slid += tool.out.state == ContactState::slip;
    const auto slope = [&](int k, double h) {
      return Vec3((force(x + h * Vec3::Unit(k)) - force(x - h * Vec3::Unit(k))) / (2 * h));
    };
    for (int k = 0; k < 3 && i > 1; ++k) {
      const Vec3 rough = slope(k, 1e-8), fine = slope(k, 3e-9);
      if ((rough - fine).norm() > 1e-5 * fine.norm()) continue;  // a ring begins to slip between
      ++checked;
      EXPECT_LT((Vec3(tangent[k], tangent[3 + k], tangent[6 + k]) - fine).norm(),
                1e-4 * (1 + fine.norm()))
          << "tick " << i;
    }
    tool.tick(x);
  }
  EXPECT_GT(slid, 20);
  EXPECT_GT(checked, 300);
}

}  // namespace
}  // namespace palpate::test
