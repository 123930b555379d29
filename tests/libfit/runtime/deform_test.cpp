// The surface as it is shown under a tool.

#include <gtest/gtest.h>

#include <cstring>

#include "models.hpp"

namespace palpate::test {
namespace {

using runtime::deform;
using runtime::Deformation;
using runtime::DentState;

constexpr double kBall_m = 0.008;

/// A model of rings whose surface moves, measured with a ball.
Model shaped_plate(int modes) {
  Model model = plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_shaped(model, 9, modes, 11);
  model.probe = sphere_spec(kBall_m, 0.3);
  return model;
}

Points shown(const Asset& asset, const Contact& contact, double radius_m = 0) {
  std::vector<float> moved(3 * static_cast<std::size_t>(asset.vertices), 7);
  EXPECT_EQ(deform(asset, contact, radius_m, 0, asset.vertices, moved.data()), Status::ok);
  Points out(asset.vertices, 3);
  for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = moved[static_cast<std::size_t>(i)];
  return out;
}

TEST(deform, nothing_moves_without_contact) {
  const Loaded plate = load(shaped_plate(3));
  Tool tool(plate.asset);
  EXPECT_EQ(shown(plate.asset, tool.contact), Points::Zero(plate.asset.vertices, 3));
  tool.go({0.001, 0, 0.003}, {0.001, 0, 0.001}, 1e-4);
  EXPECT_EQ(shown(plate.asset, tool.contact), Points::Zero(plate.asset.vertices, 3));
  tool.go({0.001, 0, 0.001}, {0.001, 0, -0.003}, 1e-4);
  EXPECT_GT(shown(plate.asset, tool.contact).norm(), 0.002);
  tool.go({0.001, 0, -0.003}, {0.001, 0, 0.001}, 1e-4);
  EXPECT_EQ(shown(plate.asset, tool.contact), Points::Zero(plate.asset.vertices, 3));
}

// A plate whose points are all alike: wherever the tool presses, the dent is the same one.
TEST(deform, the_dent_goes_along_with_the_contact_point) {
  Model model = shaped_plate(0);
  for (Eigen::Index p = 1; p < model.shape.point.rows(); ++p)
    model.shape.point.row(p) = model.shape.point.row(0);
  const Loaded plate = load(model);
  constexpr int kRow = 17, kCells = 3;
  const double cell_m = 0.08 / 16;
  const auto pressed = [&](double x, double y) {
    Tool tool(plate.asset);
    tool.go({x, y, 0.001}, {x, y, -0.004}, 5e-5);
    return shown(plate.asset, tool.contact);
  };
  const Points here = pressed(-0.0091, -0.0037),
               there = pressed(-0.0091 + kCells * cell_m, -0.0037);
  int compared = 0;
  for (int j = 0; j < kRow; ++j)
    for (int i = 0; i + kCells < kRow; ++i) {
      const Vec3 a = here.row(j * kRow + i), b = there.row(j * kRow + i + kCells);
      EXPECT_LT((a - b).norm(), 1e-8) << i << ' ' << j;  // of millimetres
      compared += a.norm() > 1e-4;
    }
  EXPECT_GT(compared, 40);
}

TEST(deform, a_press_and_a_slide_move_every_vertex_steadily_over_edges) {
  const unsigned seed = 12;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-0.02, 0.02);
  const Loaded plate = load(shaped_plate(3));
  constexpr double kStep_m = 2e-6, kMost = 25;  // times the step
  for (int path = 0; path < 6; ++path) {
    Tool tool(plate.asset);
    Vec3 tip(draw(random), draw(random), 0.0001);
    tool.tick(tip);
    Points before = shown(plate.asset, tool.contact);
    int edges = 0, triangle = -1;
    for (int leg = 0; leg < 3; ++leg) {
      Vec3 to(draw(random), draw(random), -0.003 - 0.04 * std::abs(draw(random)));
      if (leg == 0) to.head<2>() = tip.head<2>();
      const Vec3 way = (to - tip).normalized() * kStep_m;
      for (int k = 0; k < 2500; ++k) {
        tip += way;
        tool.tick(tip);
        if (k % 5) continue;
        const Points now = shown(plate.asset, tool.contact);
        ASSERT_LT((now - before).rowwise().norm().maxCoeff(), 5 * kMost * kStep_m)
            << "seed " << seed << ", path " << path << ", leg " << leg << ", tick " << k;
        before = now;
        edges += tool.out.triangle != triangle;
        triangle = tool.out.triangle;
      }
    }
    EXPECT_GT(edges, 1) << path;
  }
}

TEST(deform, no_vertex_is_left_inside_the_ball) {
  const unsigned seed = 13;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-0.02, 0.02);
  const Loaded plate = load(shaped_plate(2));
  for (const double tool_radius_m : {0.0, 0.011})
    for (int round = 0; round < 30; ++round) {
      Contact contact;
      Output out;
      Vec3 tip(draw(random), draw(random), 0.02);
      const Vec3 to(tip[0] + 0.2 * draw(random), tip[1], tool_radius_m - 0.006);
      for (int k = 0; k <= 400; ++k) {
        const Vec3 at = tip + (to - tip) * (k / 400.0);
        runtime::touch_ball(plate.asset, contact, at.data(), tool_radius_m, out);
      }
      ASSERT_NE(out.state, ContactState::air);
      DentState state;
      ASSERT_TRUE(runtime::shape_state(plate.asset, contact, tool_radius_m, state));
      const double radius_m = tool_radius_m > 0 ? tool_radius_m : kBall_m;
      EXPECT_EQ(state.radius_m, radius_m);
      const Vec3 centre(state.centre.x, state.centre.y, state.centre.z);
      const Points moved = shown(plate.asset, contact, tool_radius_m);
      int pushed = 0;
      for (int v = 0; v < plate.asset.vertices; ++v) {
        const runtime::Vec3d rest = plate.asset.vertex_at(v);
        const double away = (Vec3(rest.x, rest.y, rest.z) + Vec3(moved.row(v)) - centre).norm();
        ASSERT_GE(away, radius_m * (1 - 1e-6)) << "seed " << seed << ", round " << round;
        pushed += away < radius_m * (1 + 1e-6);
      }
      EXPECT_GT(pushed, 0);
    }
}

TEST(deform, a_body_held_anywhere_else_is_dented_alike) {
  Model model = shaped_plate(2), moved = model;
  const Vec3 by(12.5, -3.25, 0.75);
  moved.surface.vertices.rowwise() += by.transpose();
  const Loaded here = load(model), there = load(moved);
  Tool a(here.asset), b(there.asset);
  a.go({0.004, 0.003, 0.001}, {0.006, 0.003, -0.004}, 1e-4);
  b.go(by + Vec3(0.004, 0.003, 0.001), by + Vec3(0.006, 0.003, -0.004), 1e-4);
  EXPECT_LT((shown(here.asset, a.contact) - shown(there.asset, b.contact)).cwiseAbs().maxCoeff(),
            1e-9);
}

TEST(deform, vertices_shared_out_over_calls_have_the_same_bits) {
  const Loaded plate = load(shaped_plate(3));
  Tool tool(plate.asset);
  tool.go({0, 0, 0.001}, {0.001, 0, -0.004}, 1e-4);
  const auto count = static_cast<std::size_t>(plate.asset.vertices);
  std::vector<float> whole(3 * count), parts(3 * count);
  deform(plate.asset, tool.contact, 0, 0, plate.asset.vertices, whole.data());
  for (int v = 0; v < plate.asset.vertices; v += 37)
    deform(plate.asset, tool.contact, 0, v, std::min(37, plate.asset.vertices - v),
           parts.data() + 3 * v);
  EXPECT_EQ(std::memcmp(whole.data(), parts.data(), whole.size() * sizeof whole[0]), 0);
}

TEST(deform, a_contact_of_another_asset_is_refused) {
  const Loaded plate = load(shaped_plate(1)), other = load(shaped_plate(2));
  Tool tool(plate.asset);
  tool.go({0, 0, 0.001}, {0, 0, -0.004}, 1e-4);
  float moved[3] = {1, 1, 1};
  EXPECT_EQ(deform(other.asset, tool.contact, 0, 0, 1, moved), Status::contact_foreign);
  for (const float x : moved) EXPECT_EQ(x, 0);
}

TEST(deform, a_shape_response_changes_no_tick) {
  Model model = shaped_plate(3);
  const Loaded shaped = load(model);
  model.shape = {};
  const Loaded plain = load(model);
  EXPECT_GT(shaped.bytes.size(), plain.bytes.size());
  Tool a(shaped.asset), b(plain.asset);
  for (int k = 0; k < 300; ++k) {
    const Vec3 tip(1e-5 * k, 0, 0.001 - 2e-5 * k);
    EXPECT_EQ(a.tick(tip), b.tick(tip)) << k;
  }
}

}  // namespace
}  // namespace palpate::test
