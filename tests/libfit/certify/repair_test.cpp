// What a repair changes, keeps and undoes.

#include "libfit/certify/repair.hpp"

#include <gtest/gtest.h>

#include "libfit/certify/cap.hpp"
#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

RepairOptions quick() {
  RepairOptions options;
  options.facet.max_boxes = 150;
  return options;
}

bool is_same(const AssetBytes& a, const AssetBytes& b) {
  return a.size() == b.size() && std::equal(a.data(), a.data() + a.size(), b.data());
}

// It needs mu = 0.138 and has 0.1.
TEST(repair, lifts_the_friction_of_the_papers_cylinder_until_no_triangle_fails) {
  const Loaded body = load(even_cylinder(25, 0.1));
  const Repair repaired = repair(body.asset, {});
  EXPECT_EQ(repaired.before.any, 400);
  EXPECT_EQ(repaired.before.witnesses, 400);
  EXPECT_EQ(repaired.after.sum(), 0);
  EXPECT_EQ(repaired.after.witnesses, 0);
  EXPECT_GT(repaired.change.max, 0);
  EXPECT_LT(repaired.change.max, 0.05);
  const runtime::AssetView& asset = repaired.asset.asset();
  for (int v = 0; v < asset.vertices; ++v) {
    if (!asset.covered[v]) continue;
    const float mu = asset.node(v)[asset.control_offset[runtime::kFriction]];
    EXPECT_LE(mu, 0.1 + 0.05 + 1e-6);
  }
  // A fixed point: nothing is left to do.
  EXPECT_TRUE(repair(asset, {}).steps.empty());
}

// Smoothing radial normals changes nothing but near the open ends, and helps no triangle.
TEST(repair, undoes_what_does_not_help_to_the_last_bit) {
  const Loaded body = load(even_cylinder(25, 0.01));
  RepairOptions options = quick();
  options.kinds = {&kRepairKinds[1], 1};
  const Repair repaired = repair(body.asset, options);
  EXPECT_EQ(repaired.after.any, repaired.before.any);
  for (const RepairStep& step : repaired.steps) EXPECT_FALSE(step.is_kept);
  EXPECT_EQ(repaired.change.max_N, 0);
  EXPECT_TRUE(is_same(repaired.asset.bytes(), body.bytes));
}

TEST(repair, brings_side_forces_to_the_slope_of_the_stored_energy) {
  int repaired_area = 0;
  for (const unsigned seed : {2u, 4u, 6u}) {
    const Loaded body = load(random_body(seed, {0.7, 0.12, 0.2}));
    RepairOptions options = quick();
    options.kinds = {&kRepairKinds[0], 1};
    const Repair repaired = repair(body.asset, options);
    ASSERT_GT(repaired.before.any, 0) << seed;
    EXPECT_LE(repaired.after.sum(), repaired.before.sum()) << seed;
    repaired_area += repaired.after.sum() < 0.5 * repaired.before.sum();
    // What it says is what the certificate says.
    Certificate c = certify(repaired.asset.asset(), 0, options.facet.max_boxes);
    EXPECT_NEAR(c.any.certified_area, 1 - repaired.after.any_area, 1e-9) << seed;
    EXPECT_EQ(c.pulling, 0) << seed;
  }
  EXPECT_GE(repaired_area, 2);
}

TEST(repair, is_the_same_for_every_number_of_threads) {
  const Loaded body = load(random_body(2, {0.5, 0.15, 0.5}));
  RepairOptions options = quick();
  const Repair one = repair(body.asset, options);
  options.threads = 3;
  EXPECT_TRUE(is_same(repair(body.asset, options).asset.bytes(), one.asset.bytes()));
  EXPECT_GT(one.steps.size(), 0);
}

TEST(repair, says_how_far_forces_change) {
  const Loaded body = load(random_body(2, {1, 0.1, 1}));
  EXPECT_EQ(force_change(body.asset, body.asset, 0).max_N, 0);
  AssetEdit edit(body.asset);
  const int controls = body.asset.control_offset[runtime::kNormal + 1];
  for (int v = 0; v < body.asset.vertices; ++v)
    if (body.asset.covered[v] == runtime::kMeasured)
      for (int j = 0; j < controls; ++j) edit.node(v)[j] *= 1.1F;
  edit.seal();
  // Normal curve and bed are 1.1 times themselves; the side force is as it was.
  const ForceChange change = force_change(body.asset, edit.asset(), 0);
  EXPECT_NEAR(change.p95, 0.1, 0.01);
  EXPECT_LT(change.max, 0.11);
}

TEST(cap, keeps_every_curve_within_a_slope_and_those_below_it_as_they_are) {
  const Loaded body = load(random_body(1, {1, 0.1, 1}));
  const runtime::AssetView& was = body.asset;
  EXPECT_TRUE(is_same(capped(was, 1e6).bytes(), body.bytes));
  const AssetEdit edit = capped(was, 60);
  const runtime::SplineView& curve = was.curves.view[runtime::kNormal];
  for (int v = 0; v < was.vertices; ++v)
    for (int i = 0; i <= 20; ++i) {
      const double d = 0.01 * i / 20, here = runtime::curve_value(curve, edit.asset().node(v), d),
                   before = runtime::curve_value(curve, was.node(v), d);
      EXPECT_LE(runtime::curve_slope(curve, edit.asset().node(v), d), 60 * (1 + 1e-5));
      EXPECT_LE(here, before + 1e-7);
      if (i == 1) {
        EXPECT_NEAR(here, before, 0.25 * before);
      }
    }
}

TEST(cap, finds_the_stiffest_spring_that_a_device_shows_at_rest) {
  const Device device{"d", "", 8.5, 0, 3e-5, 0.04, 0.075};
  const double shown = stiffness_shown_N_m(device, 3);
  EXPECT_EQ(swinging_hands(device, shown, 3), 0);
  EXPECT_GT(swinging_hands(device, 1.05 * shown, 3), 0);
  Device weak = device;
  weak.max_stiffness_N_m = 0.5 * shown;
  EXPECT_NEAR(stiffness_shown_N_m(weak, 3), 0.5 * shown, 1e-9);
  weak.mass_kg = 0;
  EXPECT_EQ(stiffness_shown_N_m(weak, 3), 0.5 * shown);
}

TEST(asset_edit, with_other_meta_data_is_the_same_asset) {
  Model model = random_body(1, {1, 0.1, 1});
  make_shaped(model, 5, 2, 1);
  model.curves.relaxation.share = Eigen::Vector2d(0.5, 0.8);  // it lies between meta and shape
  model.curves.relaxation.time_s = Eigen::Vector2d(0.05, 0.6);
  const Loaded body = load(model);
  AssetEdit edit(body.asset);
  edit.seal(R"({"repair":")" + std::string(300, 'x') + R"("})");
  Status status;
  const Asset again = Asset::open(edit.bytes().data(), edit.bytes().size(), &status);
  ASSERT_EQ(status, Status::ok) << sentence(status);
  EXPECT_EQ(again.meta_bytes, 313u);
  EXPECT_EQ(again.shape.points, 5);
  EXPECT_EQ(again.shape.mode[7], body.asset.shape.mode[7]);
  EXPECT_EQ(again.curves.relaxation.branches, 2);
  EXPECT_EQ(again.curves.relaxation.time_s[1], 0.6);
  edit.seal(std::string(body.asset.meta, body.asset.meta_bytes));
  EXPECT_TRUE(is_same(edit.bytes(), body.bytes));
}

}  // namespace
}  // namespace palpate::certify::test
