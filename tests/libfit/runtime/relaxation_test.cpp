// A body that relaxes (docs/method-body.md, section 24), in the engine.

#include <gtest/gtest.h>

#include <cmath>

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

TEST(relaxation, the_tangent_is_the_slope_of_what_a_tick_answers) {
  const Loaded loaded = load(relaxing(plate(), 1, 0, even, two_branches()));
  Tool tool(loaded.asset, 0, 0.01);
  tool.tick({0, 0.7e-3, 1e-4});  // off the edges
  int slid = 0, checked = 0;
  for (int i = 1; i <= 120; ++i) {
    const Vec3 x(1e-4 * std::max(0, i - 40), 0.7e-3 + 3e-5 * std::max(0, i - 70),
                 -1e-4 * std::min(i, 50));
    const Contact before = tool.contact;
    const auto tick = [&](const Vec3& at, double* tangent) {
      tool.contact = before;
      touch(loaded.asset, tool.contact, at.data(), tool.out, tangent, tool.dt_s);
      return Vec3(-Vec3::Map(tool.out.force_on_tool_N));
    };
    if (i > 1) checked += expect_tangent_is_slope(tick, x);
    tick(x, nullptr);
    slid += tool.out.state == ContactState::slip;
  }
  EXPECT_GT(slid, 20);
  EXPECT_GT(checked, 300);
}

}  // namespace
}  // namespace palpate::test
