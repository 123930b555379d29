// Promises over random bodies and ways. Each failure prints its seed.

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kRange_m = 0.01;

enum class Field {
  rough,
  smooth
};  // each node its own curves; one shape that varies by 30 % over 10 cm

// A plate or sphere with random cubic curves.
void randomize(Model& model, std::mt19937& random, double friction, Field field) {
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::Index vertices = model.surface.vertices.rows();
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const CurveBasis basis{3, {0, 0.0015, 0.004, 0.006, kRange_m}};
    model.curves.basis[kind] = basis;
    model.curves.control[kind] = Controls::Zero(vertices, basis.size());
    const double scale = (kind == 0 ? 4 : kind == 1 ? 3 : 4 * friction) / basis.size();
    const double turn = 6 * unit(random);
    std::vector<double> step(static_cast<std::size_t>(basis.size()));
    for (double& each : step) each = 0.8 + 0.4 * unit(random);
    for (Eigen::Index v = 0; v < vertices; ++v) {
      const Vec3 x = model.surface.vertices.row(v);
      const double here =
          1 + 0.15 * std::sin(60 * (x[0] * std::cos(turn) + x[1] * std::sin(turn)) + turn);
      for (int j = 1; j < basis.size(); ++j)
        model.curves.control[kind](v, j) =
            model.curves.control[kind](v, j - 1) +
            scale * (field == Field::smooth ? here * step[static_cast<std::size_t>(j)]
                                            : 0.8 + 0.4 * unit(random));
    }
  }
}

Loaded random_body(unsigned seed, double friction, bool is_round, Field field) {
  std::mt19937 random(seed);
  Model model = is_round ? sphere_model(0.03, 40, uniform(400, 300, 0.3))
                         : plate_model(0.1, 20, uniform(400, 300, 0.3));
  randomize(model, random, friction, field);
  return load(model);
}

Vec3 draw(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> share(-size, size);
  const double x = share(random), y = share(random), z = share(random);
  return {x, y, z};
}

// Work on the body along a straight way by five Gauss points on each of `pieces` parts.
double gauss_work_J(Tool& tool, const Vec3& from_m, const Vec3& to_m, int pieces) {
  static constexpr double kAt[] = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                   0.953089922969332};
  static constexpr double kWeight[] = {0.118463442528095, 0.239314335249683, 0.284444444444444,
                                       0.239314335249683, 0.118463442528095};
  double sum = 0;
  for (int i = 0; i < pieces; ++i)
    for (int g = 0; g < 5; ++g) {
      const Vec3 f = tool.tick(from_m + (to_m - from_m) * ((i + kAt[g]) / pieces));
      sum += kWeight[g] / pieces * f.dot(to_m - from_m);
    }
  return sum;
}

TEST(property, closed_loops_at_a_fixed_contact_do_no_work_whatever_the_curves) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Loaded body = random_body(seed, 1e6, seed % 3 == 0, Field::rough);
    std::mt19937 random(100 + seed);
    Tool tool(body.asset);
    const Vec3 surface = seed % 3 == 0 ? Vec3(0.004, 0.0031, 0.0295) : Vec3(0.004, 0.0031, 0);
    Vec3 at = surface - Vec3(0, 0, 0.004);
    tool.go(surface + Vec3(0, 0, 0.002), at, 1e-4);
    ASSERT_EQ(tool.out.state, ContactState::stick) << "seed " << seed;
    double work_J = 0, path_J = 0;
    const Vec3 start = at;
    for (int corner = 0; corner < 5; ++corner) {
      const Vec3 to = corner == 4 ? start : Vec3(start + draw(random, 0.0025));
      const double side_J = gauss_work_J(tool, at, to, 400);
      ASSERT_EQ(tool.out.state, ContactState::stick) << "seed " << seed;
      work_J += side_J;
      path_J += std::abs(side_J);
      at = to;
    }
    EXPECT_GT(path_J, 1e-4);
    EXPECT_LT(std::abs(work_J), 1e-9 * path_J) << "seed " << seed;
  }
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
    const Loaded body = random_body(seed, 0.3, seed % 3 == 0, Field::rough);
    std::mt19937 random(200 + seed);
    for (int walk = 0; walk < 20; ++walk) {
      Tool tool(body.asset);
      const Vec3 above = seed % 3 == 0 ? Vec3(0, 0, 0.0305) : Vec3(0, 0, 0.0005);
      Vec3 x = above;
      tool.tick(x);
      const Vec3 goal = above - Vec3(0, 0, 0.004) + draw(random, 0.003) +
                        6 * Vec3(draw(random, 0.003)[0], draw(random, 0.003)[1], 0);
      const double step = std::pow(10.0, -5 + 2 * walk / 20.0);
      for (int i = 0; i < 300; ++i) {
        x += (goal - x).normalized() * std::min(step, (goal - x).norm());
        tool.tick(x);
        ASSERT_EQ(tool.status, Status::ok)
            << "seed " << seed << ", walk " << walk << ", tick " << i;
        const unsigned held =
            runtime::kFlagUnfinished | runtime::kFlagHeldBack | runtime::kFlagBorder;
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

TEST(property, edge_crossings_at_50_mm_per_s_are_no_larger_than_two_ordinary_ticks) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Loaded body = random_body(seed, 0.3, false, Field::smooth);
    std::mt19937 random(300 + seed);
    const Vec3 along = Vec3(draw(random, 1)[0], draw(random, 1)[1], 0).normalized();
    const Vec3 start =
        Vec3(0, 0, -0.0025) - 0.02 * along + 0.1 * draw(random, 0.01).cwiseProduct(Vec3(1, 1, 0));
    Tool tool(body.asset);
    tool.go(start + Vec3(0, 0, 0.004), start, 5e-5);
    Vec3 before = tool.go(start, start + 0.005 * along, 5e-5);
    double crossing_N = 0, ordinary_N = 0;
    int triangle = tool.out.triangle, crossings = 0;
    for (int tick = 1; tick <= 600; ++tick) {
      const Vec3 f = tool.tick(start + (0.005 + 5e-5 * tick) * along);
      const double jump = (f - before).norm();
      const bool crosses = tool.out.triangle != triangle;
      crossings += crosses;
      (crosses ? crossing_N : ordinary_N) = std::max(crosses ? crossing_N : ordinary_N, jump);
      triangle = tool.out.triangle;
      before = f;
    }
    EXPECT_GE(crossings, 5) << "seed " << seed;
    EXPECT_LE(crossing_N, 2 * ordinary_N) << "seed " << seed;
    EXPECT_LE(crossing_N, 0.04) << "seed " << seed;
  }
}

TEST(property, lifting_off_from_any_slide_ends_in_silence_without_a_pop) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Loaded body = random_body(seed, 0.3, seed % 3 == 0, Field::smooth);
    std::mt19937 random(400 + seed);
    const double top = seed % 3 == 0 ? 0.03 : 0;
    const double max_N = 5e-6 * 2000;
    Tool tool(body.asset);
    const Vec3 start(0.001, 0.002, top + 0.001);
    Vec3 x = start - Vec3(0, 0, 0.005);
    tool.go(start, x, 1e-4);
    const Vec3 aside = Vec3(draw(random, 0.004)[0], draw(random, 0.004)[1], 0);
    Vec3 before = tool.go(x, x + aside, 2e-5);
    x += aside;
    double last_N = 0;
    for (int i = 0; i < 4000 && tool.contact.triangle >= 0; ++i) {
      const Vec3 f = tool.tick(x += Vec3(0.3, -0.2, 1) * 5e-6);
      ASSERT_LT((f - before).norm(), max_N) << "seed " << seed << ", tick " << i;
      if (f.norm() > 0) last_N = f.norm();
      before = f;
    }
    EXPECT_EQ(tool.out.state, ContactState::air) << "seed " << seed;
    EXPECT_LT(last_N, max_N) << "seed " << seed;
    EXPECT_EQ(tool.contact.ledger.refused_ticks, 0) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate::test
