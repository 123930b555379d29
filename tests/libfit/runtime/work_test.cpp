// The bound on a slip's work that palpate.h states, counted.

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

long curves_read = 0;
int moves = 0;

// The engine's own spot, path and surface; whoever reads a curve is counted.
template <class S>
struct CountedSpot : runtime::MeshSpot<S> {};
template <int kOrder, class S>
runtime::LiveControls<kOrder, S> live_controls(const CountedSpot<S>& spot, int curve,
                                               int first) noexcept {
  ++curves_read;
  const runtime::MeshSpot<S>& whole = spot;
  return runtime::live_controls<kOrder>(whole, curve, first);
}
struct CountedPath {
  runtime::MeshPath<double, false> whole;
  double end() const noexcept { return whole.end(); }
  bool is_blocked() const noexcept { return whole.is_blocked(); }
  bool is_straight() const noexcept { return whole.is_straight(); }
  const CountedPath& plain() const noexcept { return *this; }
  template <class S>
  CountedSpot<S> at(const S& s) const noexcept {
    return {whole.at(s)};
  }
};
struct CountedSurface {
  runtime::MeshSurface<double, false> whole;
  CountedSpot<double> standing() const noexcept { return {whole.standing()}; }
  CountedPath aim(const CountedSpot<double>& spot, const runtime::Vec3d& lateral) noexcept {
    return {whole.aim(spot, lateral)};
  }
  bool is_spent() const noexcept { return whole.is_spent(); }
  void move(const CountedPath& path, double s) noexcept {
    ++moves;
    whole.move(path.whole, s);
  }
};

TEST(work, of_a_slip_is_no_more_than_the_header_states) {
  const Loaded bodies[] = {load(plate_model(0.1, 80, uniform(400, 300, 0.3))),
                           load(sphere_model(0.03, 40, uniform(400, 300, 0.1)))};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  long max_read = 0;
  int max_moves = 0;
  for (int slip = 0; slip < 4000; ++slip) {
    const bool is_round = slip % 2 == 1;
    const Asset& asset = bodies[slip % 2].asset;
    Tool tool(asset);
    const double top_m = is_round ? 0.03 : 0;
    const Vec3 start(0.003 * share(random), 0.003 * share(random), top_m - 0.002);
    tool.go(start + Vec3(0, 0, 0.003), start, 5e-4);
    if (tool.out.state == ContactState::air) continue;
    const double reach_m = std::pow(10.0, -5 + 3.5 * (share(random) + 1) / 2);
    const Vec3 goal = start + reach_m * Vec3(share(random), share(random), 0.1 * share(random));
    const auto x =
        runtime::make_vec3<double>(goal.data()) - runtime::make_vec3<double>(asset.origin_m);
    curves_read = moves = 0;
    runtime::Corners corners;
    CountedSurface surface{
        {corners, asset, tool.contact.triangle, tool.contact.weight, tool.contact.arm}};
    using runtime::Separable;
    auto memory = Separable::load<double>(runtime::no_memory());
    auto kinematics = Separable::kinematics(asset.curves, surface.standing(), x, memory);
    runtime::slide<Separable>(asset.curves, x, surface, kinematics, memory);
    const auto slipped = Separable::slip(asset.curves, {}, kinematics, memory);
    Separable::answer(asset.curves, {}, kinematics, slipped);
    // An evaluation reads f^r and L; the kinematics before the first segment and the force, one
    // each.
    constexpr int kMaxEvaluations = runtime::kMaxRootSteps + 4;
    ASSERT_LE(moves, runtime::kMaxSegments) << "seed 5, slip " << slip;
    ASSERT_LE(curves_read, 2 * kMaxEvaluations * std::max(moves, 1) + 3) << "seed 5, slip " << slip;
    max_read = std::max(max_read, curves_read);
    max_moves = std::max(max_moves, moves);
  }
  EXPECT_EQ(runtime::kMaxSegments, 16) << "palpate.h states it";
  EXPECT_EQ(runtime::kMaxRootSteps + 4, 16) << "palpate.h states it";
  EXPECT_EQ(max_moves, runtime::kMaxSegments) << "no slip was long: the test shows little";
  EXPECT_GT(max_read, 60);
}

}  // namespace
}  // namespace palpate::test
