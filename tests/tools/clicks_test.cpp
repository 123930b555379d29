// The paper's clicks: where they come from, and that they are the independent reference's.

#include <gtest/gtest.h>

#include <numbers>

#include "tests/libfit/runtime/models.hpp"
#include "tests/support/bodies.hpp"
#include "tests/support/from_touch.hpp"
#include "tools/workshop/bench/clicks.hpp"
#include "tools/workshop/bench/tick_work.hpp"

namespace palpate::tools {
namespace {

TEST(clicks, come_from_either_interpolation_that_is_switched_off) {
  const auto results = measure_clicks(6);
  ASSERT_EQ(results.size(), std::size(kClickCases));
  for (std::size_t i = 0; i < results.size(); ++i) {
    const ClickResult& r = results[i];
    const Ablation& ablation = kClickCases[i].ablation;
    EXPECT_GE(r.crossings, 30) << r.name;
    if (ablation.blends_normals && ablation.blends_curves) {
      EXPECT_LT(r.median_jump_N, 0.004) << r.name;
      EXPECT_LT(r.max_jump_N, 0.04) << r.name;
      EXPECT_LT(r.click_index, 1.5) << r.name;
    } else {
      EXPECT_GT(r.max_jump_N, 5 * results[0].max_jump_N) << r.name;
      EXPECT_GT(r.click_index, 3) << r.name;
    }
  }
}

// Largest change of force between samples of case T2_scan: a contact point that goes over the
// cylinder, the tip 4 mm under it and 1 mm ahead along z, whatever friction would say.
double scan_jump_N(const runtime::Asset& asset, const Ablation& ablation, int samples) {
  double worst_N = 0;
  runtime::Vec3d before{0, 0, 0};
  for (int i = 0; i < samples; ++i) {
    const double share = double(i) / (samples - 1), angle = 0.1 + 1.2 * std::numbers::pi * share;
    const double z = 0.012 + 0.076 * share;
    const double sector = 2 * std::numbers::pi / 25, row_m = 0.01;
    const int column = static_cast<int>(angle / sector), row = static_cast<int>(z / row_m);
    // On the chord of its sector at that angle, then within the quad's two triangles.
    const double from_m = 0.03 * std::sin(angle - column * sector),
                 to_m = 0.03 * std::sin((column + 1) * sector - angle);
    const double across = from_m / (from_m + to_m), up = z / row_m - row;
    const bool is_upper = up > across;
    const double n[3] = {is_upper ? 1 - up : 1 - across, is_upper ? across : across - up,
                         is_upper ? up - across : up};
    const int triangle = 2 * (row * 25 + column) + (is_upper ? 1 : 0);
    const runtime::Arm none;
    runtime::Corners corners;
    const runtime::MeshSurface<double, false> surface(corners, asset, triangle, n, none);
    const runtime::Vec3d facet = runtime::normalized(asset.area_vector(triangle)) * -1.0;
    const auto spot = ablated(surface.standing(), ablation, facet);
    const runtime::Vec3d x{0.026 * std::cos(angle) - asset.origin_m[0],
                           0.026 * std::sin(angle) - asset.origin_m[1],
                           z + 0.001 - asset.origin_m[2]};
    const runtime::Vec3d f = test::force_from_touch(asset.curves, spot, x), step = f - before;
    if (i > 0) worst_N = std::max(worst_N, std::sqrt(dot(step, step)));
    before = f;
  }
  return worst_N;
}

TEST(clicks, of_the_reference_scan_are_the_references) {
  ExportOptions options;
  options.fades_borders = false;
  const test::Loaded cylinder = test::load(test::cylinder_model(), options);
  const struct {
    Ablation ablation;
    double of_1000_N, of_2000_N, of_4000_N;  // cases/runtime/summary.json, T2
  } cases[] = {{{}, 0.007764411216388, 0.003896157948767, 0.001956135853680},
               {{false, true}, 0.256999502112803, 0.259883463214731, 0.261327877768865},
               {{true, false}, 0.060608587607553, 0.060998904849245, 0.061796389518309},
               {{false, false}, 0.264902782069003, 0.267709264876870, 0.269114280589176}};
  for (const auto& c : cases) {
    EXPECT_NEAR(scan_jump_N(cylinder.asset, c.ablation, 1000), c.of_1000_N, 2e-6);
    EXPECT_NEAR(scan_jump_N(cylinder.asset, c.ablation, 2000), c.of_2000_N, 2e-6);
    EXPECT_NEAR(scan_jump_N(cylinder.asset, c.ablation, 4000), c.of_4000_N, 2e-6);
  }
}

// The engine begins a root where the last slip ended, so the two meet it to its tolerance alone.
TEST(clicks, nothing_ablated_is_the_engine_itself_but_for_the_tolerance_of_roots) {
  const BenchAsset body = make_bench_asset(bench_cylinder(25, 10));
  runtime::AssetView asset = body.asset;
  asset.has_guard = false;
  AblatedTip ablated(asset, {});
  runtime::Contact contact;
  runtime::Output out;
  for (long i = 0; i < 3000; ++i) {
    const Vec3 x = kTicksOfKind[2].tip(i - 1) * (i == 0 ? 1.2 : 1);
    runtime::touch(asset, contact, x.data(), out);
    const runtime::Vec3d f = ablated.tick(x.data());
    ASSERT_NEAR(f.x, -out.force_on_tool_N[0], 1e-10) << i;
    ASSERT_NEAR(f.z, -out.force_on_tool_N[2], 1e-10) << i;
  }
}

}  // namespace
}  // namespace palpate::tools
