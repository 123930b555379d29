// What is certified creates no energy, however it is attacked, with the guard off; what fails has a
// witness that does. Failures print the seed.

#include <gtest/gtest.h>

#include "tests/libfit/certify/attack.hpp"

namespace palpate::certify::test {
namespace {

using runtime::Vec3d;

Model rigid_body(unsigned seed) { return random_body(seed, random_kind(seed)); }

TEST(certificate, no_slip_from_any_state_of_the_rings_creates_energy_where_it_is_certified) {
  const Attack sum = attack(OtherRings::any, rigid_body);
  EXPECT_GT(sum.slips, 5000);
  EXPECT_GT(sum.created, 100) << "too weak to find what is not certified";
}
TEST(certificate, no_gross_slip_creates_energy_where_it_is_certified) {
  const Attack sum = attack(OtherRings::sliding, rigid_body);
  EXPECT_GT(sum.slips, 10000);
  EXPECT_GT(sum.created, 100) << "too weak to find what is not certified";
}

// Curves that turn concave near their end: rings there are cut, on some bodies over all of it.
Model concave_body(unsigned seed) {
  const Kind kind = random_kind(seed);
  Model model = random_body(seed, {kind.friction, 0.2 * kind.unevenness, kind.side});
  const auto wave = waves(seed);
  const Controls before = model.curves.control[0];
  model.curves.basis[0] = {3, {0, 0.01}};
  model.curves.control[0] = Controls::Zero(before.rows(), 4);
  for (Eigen::Index v = 0; v < before.rows(); ++v) {
    const double end = 0.5 + 0.02 * wave(model.surface.vertices.row(v)) - 0.05 * (seed % 3);
    model.curves.control[0].row(v) << 0, 0.04, 0.3, end;
    model.curves.control[0].row(v) *= before(v, 2) / 0.57;
  }
  return model;
}
TEST(certificate, no_slip_creates_energy_over_a_bed_that_is_cut_and_certified) {
  const Attack any = attack(OtherRings::any, concave_body, 30),
               gross = attack(OtherRings::sliding, concave_body, 30);
  EXPECT_GT(any.slips, 500);
  EXPECT_GT(gross.slips, 1000);
  EXPECT_GT(any.created + gross.created, 100) << "too weak to find what is not certified";
}

// Each tick's exact work, the guard off.
TEST(certificate, no_walk_over_a_certified_body_creates_energy_at_any_tick) {
  long slips = 0;
  for (unsigned seed = 2; seed <= 12; seed += 2) {
    const Loaded body = load(random_body(seed, {1, 0.06, 1}));
    const Certificate certificate = certify(body.asset);
    ASSERT_TRUE(certificate.certified()) << "seed " << seed << ": " << in_words(certificate);
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    double work_J = 0, moved_J = 0, stored_J = 0;
    walk(bare, seed, 400, 0.0095, [&](const Output& out, double lost_J, int leg) {
      const double done_J = out.stored_J + lost_J - stored_J;
      EXPECT_GE(lost_J, -1e-12 * moved_J) << "seed " << seed << ", leg " << leg;
      work_J += done_J;
      moved_J += std::abs(done_J);
      stored_J = out.stored_J;
      slips += out.state == ContactState::slip;
    });
    EXPECT_GE(work_J, stored_J - 1e-12 * moved_J) << "seed " << seed;
  }
  EXPECT_GT(slips, 50000);
}

TEST(certificate, a_bound_over_a_patch_and_depths_holds_every_place_and_depth_of_it) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto point = [&] {
    const double p = unit(random), q = unit(random);
    return p + q > 1 ? PatchPoint{{p + q - 1, 1 - p, 1 - q}} : PatchPoint{{1 - p - q, p, q}};
  };
  int finite = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const Loaded body = load(random_body(seed, random_kind(seed)));
    FacetOptions options;
    options.radius_m = seed % 3 == 0 ? 0.004 : 0;
    for (int t = static_cast<int>(seed); t < body.asset.triangles; t += 40) {
      if (!(range_of(body.asset, t) > 0)) continue;
      const Facet facet = facet_of(body.asset, t, options);
      const Patch patch{{point(), point(), point()}};
      const double to_m = range_of(body.asset, t) * unit(random), from_m = to_m * unit(random);
      const auto depths = over_depths(body.asset, facet, t, from_m, to_m);
      for (const OtherRings others : {OtherRings::any, OtherRings::sliding}) {
        const double bound = balance(facet, patch, depths, others).ratio;
        finite += std::isfinite(bound);
        for (int i = 0; i < 10; ++i) {
          const PatchPoint within = point();
          PatchPoint place{{0, 0, 0}};
          for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l) place.n[k] += within.n[l] * patch.corner[l].n[k];
          const double d = from_m + (to_m - from_m) * unit(random);
          const double here =
              balance(facet, place, at_depth(body.asset, facet, t, d), others).ratio;
          EXPECT_LE(here, bound) << "seed " << seed << ", triangle " << t << ", depth " << d;
        }
      }
    }
  }
  EXPECT_GT(finite, 200);
}

TEST(certificate, a_witness_creates_the_energy_that_it_says) {
  int witnesses = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const Loaded body = load(random_body(seed, {0.1, 0.4, 0}));
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    FacetOptions options;
    options.max_boxes = 60;
    for (int t = static_cast<int>(seed); t < bare.triangles; t += 40) {
      if (!(range_of(bare, t) > 0) || !bare.covered[bare.corner(t, 0)] ||
          !bare.covered[bare.corner(t, 1)] || !bare.covered[bare.corner(t, 2)])
        continue;
      const Sliding sliding = certify_sliding(bare, t, OtherRings::sliding, options);
      if (sliding.verdict != Verdict::fails) continue;
      ++witnesses;
      // From what it says: gross slip, all rings 20 um beyond their limits or less.
      const Witness& w = sliding.witness;
      const Facet e = facet_of(bare, t, options);
      const Vec3d along = runtime::make_vec3<double>(w.direction);
      double most_J = 0;
      for (const double beyond_m : {2e-5, 5e-6, 1e-6}) {
        SlipState state{{{w.weight[0], w.weight[1], w.weight[2]}}, w.depth_m, {}};
        for (int i = 0; i < kRings; ++i)
          state.ring[i] =
              along * (std::max(w.deflection_m * (1 - e.threshold[i] / w.depth_m), 0.0) + beyond_m);
        StagedContact staged = stage(bare, t, 0, state);
        Output out;
        touch(bare, staged.contact, staged.tip_m, out);
        most_J = std::max(most_J, -out.dissipated_J);
        // The guard takes it back: nothing is dissipated, nothing is created.
        StagedContact guarded = stage(body.asset, t, 0, state);
        touch(body.asset, guarded.contact, guarded.tip_m, out);
        EXPECT_GE(out.dissipated_J, -1e-12 * out.stored_J);
      }
      EXPECT_GT(w.created_J, 0) << "seed " << seed;
      EXPECT_NEAR(most_J, w.created_J, 1e-9 * w.created_J) << "seed " << seed << ", triangle " << t;
    }
  }
  EXPECT_GT(witnesses, 50);
}

// With a tenth more than the share of its friction that the bound asks for no slip creates energy;
// with a tenth less than what was found the engine's does.
TEST(certificate, the_friction_that_is_asked_for_is_where_the_engine_begins_to_create_energy) {
  int checked = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    FacetOptions options;
    options.far = 0;
    const Loaded body = load(random_body(seed, {1, 0.1, 0}));
    for (int t = static_cast<int>(seed); t < body.asset.triangles; t += 120) {
      if (!(range_of(body.asset, t) > 0)) continue;
      const Sliding sliding = certify_sliding(body.asset, t, OtherRings::sliding, options);
      if (!(sliding.ratio < 1)) continue;
      EXPECT_LT(sliding.ratio, 1.5 * sliding.worst_found) << "seed " << seed << ", triangle " << t;
      for (const bool is_enough : {true, false}) {
        const double factor = is_enough ? 1.1 * sliding.ratio : 0.9 * sliding.worst_found;
        const Loaded again = load(random_body(seed, {factor, 0.1, 0}));
        const Sliding now = certify_sliding(again.asset, t, OtherRings::sliding, options);
        EXPECT_EQ(now.verdict == Verdict::fails, !is_enough)
            << "seed " << seed << ", triangle " << t << ", ratio " << sliding.ratio << ", found "
            << sliding.worst_found << ", now " << now.ratio << ", " << now.worst_found;
      }
      ++checked;
    }
  }
  EXPECT_GT(checked, 20);
}

}  // namespace
}  // namespace palpate::certify::test
