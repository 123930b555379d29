// Promises over random bodies and ways. Each failure prints its seed.

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

// A plate or sphere whose nodes have random cubic curves.
Loaded random_body(unsigned seed, double friction, bool is_round) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Model model = is_round ? sphere_model(0.03, 40, uniform(400, 300, 0.3))
                         : plate_model(0.1, 20, uniform(400, 300, 0.3));
  const Eigen::Index vertices = model.surface.vertices.rows();
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const CurveBasis basis{3, {0, 0.0015, 0.004, 0.006, 0.01}};
    model.curves.basis[kind] = basis;
    model.curves.control[kind] = Controls::Zero(vertices, basis.size());
    const double scale = (kind == 0 ? 4 : kind == 1 ? 3 : 4 * friction) / basis.size();
    for (Eigen::Index v = 0; v < vertices; ++v)
      for (int j = 1; j < basis.size(); ++j)
        model.curves.control[kind](v, j) =
            model.curves.control[kind](v, j - 1) + scale * (0.8 + 0.4 * unit(random));
  }
  return load(model);
}

double blended(const Asset& asset, const Output& out, int curve, double at_m) {
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += out.weight[k] *
           runtime::curve_value(
               asset.curves.view[curve],
               asset.node(asset.corner(out.triangle, k)) + asset.control_offset[curve], at_m);
  return sum;
}

TEST(property, finished_slips_end_at_the_limit) {
  long slips = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Loaded body = random_body(seed, 0.3, seed % 3 == 0);
    std::mt19937 random(200 + seed);
    for (int walk = 0; walk < 20; ++walk) {
      Tool tool(body.asset);
      const Vec3 above = seed % 3 == 0 ? Vec3(0, 0, 0.0305) : Vec3(0, 0, 0.0005);
      Vec3 x = above;
      tool.tick(x);
      const Vec3 goal = above - Vec3(0, 0, 0.004) + drawn_vector(random, 0.003) +
                        6 * Vec3(drawn_vector(random, 0.003)[0], drawn_vector(random, 0.003)[1], 0);
      const double step = std::pow(10.0, -5 + 2 * walk / 20.0);
      for (int i = 0; i < 300; ++i) {
        x += (goal - x).normalized() * std::min(step, (goal - x).norm());
        tool.tick(x);
        ASSERT_EQ(tool.status, Status::ok)
            << "seed " << seed << ", walk " << walk << ", tick " << i;
        const unsigned held =
            PALPATE_FLAG_UNFINISHED | PALPATE_FLAG_HELD_BACK | PALPATE_FLAG_BORDER;
        if (tool.out.state == ContactState::air || (tool.out.flags & held)) continue;
        const double limit_N = blended(body.asset, tool.out, 2, tool.out.normal_m);
        const double lateral_N = blended(body.asset, tool.out, 1, tool.out.lateral_m);
        ASSERT_LE(lateral_N, limit_N * (1 + 1e-6))
            << "seed " << seed << ", walk " << walk << ", tick " << i;
        if (tool.out.state != ContactState::slip) continue;
        ++slips;
        ASSERT_NEAR(lateral_N, limit_N, 1e-6 * limit_N)
            << "seed " << seed << ", walk " << walk << ", tick " << i;
      }
    }
  }
  EXPECT_GT(slips, 2000);
}

}  // namespace
}  // namespace palpate::test
