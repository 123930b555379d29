// Whole slides on the mesh: the independent reference of the cylinder, continuity at edges.

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kPeak_N = 0.9397;  // of the reference slide

Vec3 reference_tip(int tick) {  // in 0.2 s, along in 0.8 s, out in 0.2 s at 1 kHz
  const double in = std::clamp(tick / 200.0, 0.0, 1.0),
               along = std::clamp((tick - 200) / 800.0, 0.0, 1.0);
  const double out = std::clamp((tick - 1000) / 200.0, 0.0, 1.0);
  const double radius = 0.0305 - 0.0045 * (in - out), angle = 0.4 + 0.64 * along;
  return {radius * std::cos(angle), radius * std::sin(angle), 0.03 + 0.04 * along};
}

std::map<int, Vec3> reference_forces() {
  std::ifstream file(PALPATE_REFERENCE "/slide.csv");
  std::map<int, Vec3> out;
  for (std::string line; std::getline(file, line);) {
    int tick = 0, triangle = 0;
    Vec3 f;
    if (std::sscanf(line.c_str(), "%d,%d,%lf,%lf,%lf", &tick, &triangle, &f[0], &f[1], &f[2]) == 5)
      out[tick] = f;
  }
  return out;
}

Loaded load_cylinder() {
  ExportOptions options;
  options.fades_borders = false;
  return load(cylinder_model(), options);
}

TEST(slide, meets_the_reference_within_the_difference_of_the_projections) {
  // The reference slides along the orthogonal projection of u^r, the engine along the oblique one
  // (docs/method.md, 4). With the reference's projection in the engine the worst difference was
  // 6.4e-5 of the peak; with its own it is 1.8e-3.
  const Loaded cylinder = load_cylinder();
  Tool tool(cylinder.asset);
  const auto reference = reference_forces();
  ASSERT_EQ(reference.size(), 241U);
  double worst = 0, work_J = 0;
  Vec3 before_N = Vec3::Zero(), before_m = reference_tip(0);
  for (int tick = 0; tick <= 1200; ++tick) {
    const Vec3 x = reference_tip(tick), f = tool.tick(x);
    ASSERT_EQ(tool.status, Status::ok);
    work_J += 0.5 * (f + before_N).dot(x - before_m);
    before_N = f;
    before_m = x;
    if (reference.count(tick)) worst = std::max(worst, (f - reference.at(tick)).norm());
  }
  EXPECT_LT(worst, 2e-3 * kPeak_N);
  EXPECT_GT(worst, 0);
  EXPECT_NEAR(work_J, 0.009816351289916736, 1e-3 * 0.0098);
  EXPECT_EQ(tool.contact.ledger.refused_ticks, 0);
}

TEST(slide, a_long_slip_goes_on_at_the_next_ticks) {
  // 60 mm in one tick over 1.25 mm triangles: more segments than a tick may take.
  const Loaded plate = load(plate_model(0.1, 80, uniform(400, 300, 0.3)), {.max_step_m = 0.1});
  Tool tool(plate.asset);
  tool.go({-0.03, 0.001, 0.001}, {-0.03, 0.001, -0.002}, 1e-4);
  const Vec3 there(0.03, 0.0012, -0.002);
  tool.tick(there);
  EXPECT_TRUE(tool.out.flags & PALPATE_FLAG_UNFINISHED);
  int ticks = 1;
  while (tool.out.flags & PALPATE_FLAG_UNFINISHED && ticks < 100) {
    tool.tick(there);
    ++ticks;
  }
  EXPECT_LT(ticks, 20);
  EXPECT_NEAR(std::hypot(tool.out.force_on_tool_N[0], tool.out.force_on_tool_N[1]),
              0.3 * 400 * 0.002, 1e-6);
}

}  // namespace
}  // namespace palpate::test
