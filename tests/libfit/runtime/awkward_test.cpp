// Tips, surfaces and curves that nobody wants: finite, bounded, flagged.

#include <gtest/gtest.h>

#include <limits>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

Loaded load_plate(double lateral_N_m = 300, double mu = 0.4) {
  return load(plate_model(0.1, 20, uniform(400, lateral_N_m, mu)));
}

void expect_silence(const Tool& tool, const char* what) {
  for (double f : tool.out.force_on_tool_N) EXPECT_EQ(f, 0) << what;
  EXPECT_EQ(tool.out.state, ContactState::air) << what;
}

TEST(awkward, tips_that_are_not_finite_give_zero_force_and_say_so) {
  const Loaded plate = load_plate();
  for (double bad : {kNan, kInfinite, -kInfinite}) {
    for (int axis = 0; axis < 3; ++axis) {
      Tool tool(plate.asset);
      tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
      ASSERT_EQ(tool.out.state, ContactState::stick);
      Vec3 tip(0, 0.001, -0.003);
      tip[axis] = bad;
      tool.tick(tip);
      EXPECT_EQ(tool.status, Status::tip_not_finite);
      expect_silence(tool, "not finite");
      tool.tick({0, 0.001, -0.003});  // inside now: nothing until it has come out
      EXPECT_EQ(tool.status, Status::ok);
      expect_silence(tool, "after");
      tool.go({0, 0.001, -0.003}, {0, 0.001, 0.001}, 1e-4);
      tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
      EXPECT_NEAR(tool.out.force_on_tool_N[2], 1.2, 1e-5);
    }
  }
}

TEST(awkward, teleports_give_zero_force_and_say_so) {
  const Loaded plate = load_plate();
  EXPECT_EQ(plate.asset.max_step_m, 0.05);  // and not two diagonals, 283 mm
  for (double far : {0.055, 1.0, 1e6, 1e200, 1e308}) {
    Tool tool(plate.asset);
    tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
    tool.tick({far, 0.001, -0.003});
    EXPECT_EQ(tool.status, Status::tip_teleported) << far;
    expect_silence(tool, "teleport");
    tool.tick({far, 0.001, -0.003});
    EXPECT_EQ(tool.status, Status::ok) << far;
    expect_silence(tool, "resting there");
  }
}

TEST(awkward, a_contact_of_another_asset_is_reset) {
  const Loaded plate = load_plate();
  Tool tool(plate.asset);
  tool.tick({0, 0, 0.001});
  for (int triangle : {plate.asset.triangles, 1 << 30, -7}) {
    tool.contact.triangle = triangle;
    tool.tick({0, 0, -0.001});
    EXPECT_EQ(tool.status, Status::contact_foreign);
    expect_silence(tool, "foreign");
    tool.tick({0, 0, 0.001});
  }
}

TEST(awkward, a_contact_is_refused_on_another_asset_and_where_other_bytes_were_loaded) {
  const Loaded hard = load(plate_model(0.1, 20, uniform(800, 300, 0.4)));
  Loaded plate = load_plate();
  ASSERT_EQ(plate.bytes.size(), hard.bytes.size());
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
  const Vec3 tip(0, 0.001, -0.003);
  Contact other = tool.contact;
  EXPECT_EQ(touch(hard.asset, other, tip.data(), tool.out), Status::contact_foreign);
  EXPECT_EQ(tool.out.force_on_tool_N[2], 0);
  EXPECT_EQ(touch(hard.asset, other, tip.data(), tool.out), Status::ok);  // it begins anew
  std::memcpy(plate.bytes.data(), hard.bytes.data(), hard.bytes.size());
  Status status;
  plate.asset = Asset::open(plate.bytes.data(), plate.bytes.size(), &status);
  ASSERT_EQ(status, Status::ok);
  tool.tick(tip);
  EXPECT_EQ(tool.status, Status::contact_foreign);
  expect_silence(tool, "other bytes at the same place");
}

TEST(awkward, flags_say_where_the_body_was_not_measured) {
  Model model = plate_model(0.1, 20, uniform(400, 300, 0.4));
  uncover(model, [](const Vec3& x) { return x[0] >= 0.021; });
  const Loaded plate = load(model);
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.0099}, 1e-4);
  constexpr unsigned kNotMeasured = PALPATE_FLAG_OUTSIDE | PALPATE_FLAG_EXTRAPOLATED;
  EXPECT_EQ(tool.out.flags & kNotMeasured, 0U);
  tool.tick({0, 0.001, -0.0101});
  EXPECT_TRUE(tool.out.flags & PALPATE_FLAG_EXTRAPOLATED);
  tool.go({0, 0.001, -0.0101}, {0.01, 0.001, -0.003}, 1e-4);
  EXPECT_EQ(tool.out.flags & kNotMeasured, 0U);
  unsigned seen = 0;
  for (int i = 0; i < 400 && tool.contact.triangle >= 0; ++i) {
    tool.tick({0.01 + 1e-4 * i, 0.001, -0.003});
    seen |= tool.out.flags;
  }
  EXPECT_TRUE(seen & PALPATE_FLAG_OUTSIDE);
  EXPECT_EQ(tool.contact.triangle, -1);
}

TEST(awkward, a_border_blocks_the_contact_point_and_the_force_stays_at_its_limit) {
  ExportOptions options;
  options.fades_borders = false;
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.4)), options);
  Tool tool(plate.asset);
  tool.go({0.045, 0.001, 0.001}, {0.045, 0.001, -0.003}, 1e-4);
  tool.go({0.045, 0.001, -0.003}, {0.06, 0.001, -0.003}, 1e-4);
  EXPECT_TRUE(tool.out.flags & PALPATE_FLAG_BLOCKED);
  EXPECT_NEAR(-tool.out.force_on_tool_N[0], 0.4 * 1.2, 1e-6);
  Vec3 before = -Vec3::Map(tool.out.force_on_tool_N);
  for (int i = 1; i <= 400; ++i) {  // back, and on over the body
    const Vec3 f = tool.tick({0.06 - 1e-4 * i, 0.001, -0.003});
    EXPECT_LT((f - before).norm(), 0.04) << i;
    EXPECT_LE(std::abs(f[0]), 0.4 * 1.2 * (1 + 1e-6)) << i;
    before = f;
  }
  EXPECT_EQ(tool.out.flags, 0U);
  EXPECT_NEAR(tool.out.contact_m[0], 0.02 + 0.48 / 300, 1e-6);
}

TEST(awkward, zero_friction_leaves_no_lateral_force) {
  const Loaded plate = load_plate(300, 0);
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
  for (int i = 1; i < 200; ++i) {
    const Vec3 f = tool.tick({1e-4 * i, 0.001 + 3e-5 * i, -0.003});
    EXPECT_LT(f.head<2>().norm(), 1e-9) << i;
    EXPECT_NEAR(f[2], -1.2, 1e-5) << i;
  }
  EXPECT_EQ(tool.contact.ledger.refused_ticks, 0);
}

TEST(awkward, zero_lateral_stiffness_slides_as_if_frictionless_and_says_so) {
  const Loaded plate = load_plate(0, 0.4);
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
  for (int i = 1; i < 200; ++i) {
    const Vec3 f = tool.tick({1e-4 * i, 0.001, -0.003});
    EXPECT_EQ(f.head<2>().norm(), 0) << i;
    EXPECT_NEAR(f[2], -1.2, 1e-5) << i;
    EXPECT_LT(tool.out.lateral_m, 1e-9);
    EXPECT_TRUE(tool.out.flags & PALPATE_FLAG_FRICTIONLESS);
  }
}

TEST(awkward, boundless_friction_never_slips) {
  const Loaded plate = load_plate(300, 1e9);
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.003}, 1e-4);
  const Vec3 f = tool.go({0, 0.001, -0.003}, {0.03, 0.001, -0.003}, 1e-4);
  EXPECT_NEAR(f[0], 300 * 0.03, 1e-5);
  EXPECT_EQ(tool.out.state, ContactState::stick);
}

TEST(awkward, slides_along_edges_and_through_vertices_go_on) {
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.2)));
  for (const Vec3& along : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)}) {
    Tool tool(plate.asset);
    const Vec3 start(0.005, 0.005, 0);  // a vertex of the plate
    tool.go(start + Vec3(0, 0, 0.001), start - Vec3(0, 0, 0.002), 1e-4);
    ASSERT_NE(tool.out.state, ContactState::air);
    tool.go(start - Vec3(0, 0, 0.002), start - Vec3(0, 0, 0.002) + 0.03 * along, 1e-4);
    const Vec3 c = Vec3::Map(tool.out.contact_m),
               expected = start + 0.03 * along - along.normalized() * (0.16 / 300);
    EXPECT_LT((c - expected).norm(), 1e-6) << along.transpose();
  }
}

TEST(awkward, forces_fade_continuously_over_the_border_of_an_open_surface) {
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.4)));
  Tool tool(plate.asset);
  tool.go({0.03, 0.001, 0.001}, {0.03, 0.001, -0.003}, 1e-4);
  Vec3 before = tool.tick({0.03, 0.001, -0.003});
  for (int i = 1; i <= 4000; ++i) {
    const Vec3 f = tool.tick({0.03 + 1e-5 * i, 0.001, -0.003});
    EXPECT_LT((f - before).norm(), 0.01) << i;
    before = f;
  }
  EXPECT_LT(before.norm(), 1e-9);
}

TEST(awkward, a_tip_that_slid_off_the_border_feels_nothing_until_it_enters_again) {
  // Coming back at depth without lifting would store energy that nobody supplied.
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.4)));
  Tool tool(plate.asset);
  tool.go({0.03, 0.001, 0.001}, {0.03, 0.001, -0.003}, 1e-4);
  tool.go({0.03, 0.001, -0.003}, {0.06, 0.001, -0.003}, 1e-5);
  expect_silence(tool, "past the border");
  tool.go({0.06, 0.001, -0.003}, {0.0, 0.001, -0.003}, 1e-4);
  expect_silence(tool, "back at depth");
  tool.go({0.0, 0.001, -0.003}, {0.0, 0.001, 0.003}, 1e-4);
  tool.go({0.0, 0.001, 0.003}, {0.0, 0.001, -0.001}, 1e-4);
  EXPECT_NEAR(tool.out.force_on_tool_N[2], 0.4, 1e-5);
}

TEST(awkward, an_unfaded_border_holds_the_contact_point_and_says_so) {
  ExportOptions options;
  options.fades_borders = false;
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.2)), options);
  Tool tool(plate.asset);
  tool.go({0.045, 0.001, 0.001}, {0.045, 0.001, -0.002}, 1e-4);
  tool.go({0.045, 0.001, -0.002}, {0.055, 0.001, -0.002}, 1e-4);
  EXPECT_TRUE(tool.out.flags & PALPATE_FLAG_BORDER);
  EXPECT_NEAR(tool.out.contact_m[0], 0.05, 1e-8);
  const Vec3 f = tool.go({0.055, 0.001, -0.002}, {0.055, 0.011, -0.002}, 1e-4);
  EXPECT_TRUE(f.allFinite());
  EXPECT_NEAR(tool.out.contact_m[0], 0.05, 1e-8);
  EXPECT_GT(tool.out.contact_m[1], 0.005);  // it went along the border
}

TEST(awkward, degenerate_and_folded_triangles_are_air_and_counted) {
  Model model = plate_model(0.1, 20, uniform(400, 300, 0.3));
  model.surface.vertices.row(10 * 21 + 10) =
      model.surface.vertices.row(10 * 21 + 11);    // two without area
  model.inward_normal.row(5 * 21 + 5) << 0, 0, 1;  // inside out
  ExportReport report;
  make_asset_bytes(model, {}, &report);
  EXPECT_EQ(report.folded_triangles, 2 + 6);
  const Loaded plate = load(model);
  Tool tool(plate.asset);
  tool.go({-0.02, 0.0001, 0.001}, {-0.02, 0.0001, -0.003}, 1e-4);
  for (int i = 0; i < 400; ++i) {
    const Vec3 f = tool.tick({-0.02 + 1e-4 * i, 0.0001, -0.003});
    ASSERT_TRUE(f.allFinite()) << i;
    ASSERT_EQ(tool.status, Status::ok) << i;
    ASSERT_LT(f.norm(), 400 * 0.003 + 300 * 0.04) << i;
  }
}

}  // namespace
}  // namespace palpate::test
