// The tangent stiffness is the derivative of the force, on every branch the law takes.

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

struct Tally {
  std::map<std::string, int> compared, crossed;
};

std::string branch_of(const Output& out, int start_triangle) {
  std::string name = out.state == ContactState::stick ? "stick" : "slip";
  if (out.triangle != start_triangle) name += " over edges";
  if (out.flags & PALPATE_FLAG_BORDER) name += " at a border";
  if (out.flags & PALPATE_FLAG_HELD_BACK) name += " held back";
  if (out.flags & PALPATE_FLAG_FRICTIONLESS) name += " frictionless";
  return name;
}

// Compares one tick from `start` to x with central differences of ticks from the same start.
void compare(const Asset& asset, const Contact& start, const Vec3& x, double radius_m, Tally& tally,
             const std::string& place) {
  const auto tick = [&](const Vec3& at, double* tangent, Output& out) {
    Contact contact = start;
    touch_ball(asset, contact, at.data(), radius_m, out, tangent);
    return Vec3(-Vec3::Map(out.force_on_tool_N));
  };
  double k[9];
  Output out, up, down;
  const Vec3 force = tick(x, k, out);
  if (out.state == ContactState::air) {
    for (double entry : k) ASSERT_EQ(entry, 0) << place;
    return;
  }
  Output plain;
  ASSERT_EQ(tick(x, nullptr, plain), force) << "asking for a tangent changed the force, " << place;
  const std::string branch = branch_of(out, start.triangle);
  constexpr double kStep_m = 1e-8;
  double scale = 1;
  for (double entry : k) scale = std::max(scale, std::abs(entry));
  for (int j = 0; j < 3; ++j) {
    const Vec3 fu = tick(x + kStep_m * Vec3::Unit(j), nullptr, up);
    const Vec3 fd = tick(x - kStep_m * Vec3::Unit(j), nullptr, down);
    const Vec3 difference = (fu - fd) / (2 * kStep_m);
    // While a slip makes a debt, what it comes to is not differentiated.
    const bool is_held = ((out.flags | up.flags | down.flags) & PALPATE_FLAG_HELD_BACK) != 0 &&
                         out.state == ContactState::slip;
    if (is_held) {
      for (int i = 0; i < 3; ++i) ASSERT_LT(std::abs(k[3 * i + j]), 1e4) << place;
      ++tally.compared[branch];
      continue;
    }
    const bool is_one_branch = up.triangle == out.triangle && down.triangle == out.triangle &&
                               up.state == out.state && down.state == out.state &&
                               up.flags == out.flags && down.flags == out.flags;
    // A kink of the curves within the step makes the two sides differ.
    const bool is_tiny = out.lateral_m > 1e-12 && out.lateral_m < 20 * kStep_m;
    const bool is_smooth = (fu - 2 * force + fd).norm() < 2e-4 * scale * kStep_m && !is_tiny;
    if (!is_one_branch || !is_smooth) {
      ++tally.crossed[branch];
      continue;
    }
    ++tally.compared[branch];
    for (int i = 0; i < 3; ++i)
      ASSERT_NEAR(difference[i], k[3 * i + j], 2e-4 * scale)
          << place << ", " << branch << ", entry " << i << ' ' << j;
  }
}

// Winds over the asset at several speeds and compares at every tick.
void wind(const Asset& asset, double radius_m, const std::function<Vec3(double)>& path,
          unsigned seed, Tally& tally) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> speed(1e-4, 2e-2), aside(-2e-5, 2e-5);
  double t = 0;
  Contact contact;
  Output out;
  for (int i = 0; i < 1500; ++i) {
    // Every third tick only trembles, which sticks half of the time.
    const Vec3 tremble(aside(random), aside(random), aside(random));
    const Vec3 x = i % 3 == 0 ? Vec3(path(t) + tremble) : path(t += speed(random));
    if (contact.triangle >= 0)  // at first touch the contact point found counts as fixed
      compare(asset, contact, x, radius_m, tally,
              "seed " + std::to_string(seed) + ", tick " + std::to_string(i));
    if (testing::Test::HasFatalFailure()) return;
    touch_ball(asset, contact, x.data(), radius_m, out);
  }
}

Vec3 around_cylinder(double t, double radius_m) {
  const double angle = 0.4 + 0.9 * std::sin(0.7 * t),
               r = radius_m + 0.0285 + 0.002 * std::sin(1.1 * t);
  return {r * std::cos(angle), r * std::sin(angle), 0.05 + 0.045 * std::sin(0.23 * t)};
}

void expect_many(const Tally& tally, std::initializer_list<std::pair<const char*, int>> least) {
  int compared = 0, crossed = 0;
  for (const auto& [branch, count] : tally.compared) compared += count;
  for (const auto& [branch, count] : tally.crossed) crossed += count;
  for (const auto& [branch, count] : least) {
    const auto found = tally.compared.find(branch);
    EXPECT_GE(found == tally.compared.end() ? 0 : found->second, count) << branch;
  }
  EXPECT_LT(crossed, 0.12 * compared) << "too many ticks next to a change of branch";
}

TEST(tangent, is_the_derivative_of_the_force_of_a_tip_in_stick_slip_and_over_edges) {
  const Loaded cylinder = load(cylinder_model());
  Tally tally;
  wind(
      cylinder.asset, 0, [](double t) { return around_cylinder(t, 0); }, 1, tally);
  expect_many(tally, {{"stick", 100}, {"slip", 500}, {"slip over edges", 50}});
}

TEST(tangent, is_the_derivative_of_the_force_of_a_ball) {
  const Loaded cylinder = load(cylinder_model());
  for (double radius : {0.002, 0.012}) {
    Tally tally;
    wind(
        cylinder.asset, radius, [=](double t) { return around_cylinder(t, radius); }, 2, tally);
    expect_many(tally, {{"stick", 50}, {"slip", 300}, {"slip over edges", 50}});
  }
}

TEST(tangent, holds_at_borders_without_friction_and_on_rings) {
  ExportOptions options;
  options.fades_borders = false;
  const auto over_plate = [](double t) {
    return Vec3(0.052 * std::sin(0.31 * t), 0.049 * std::sin(0.17 * t + 1),
                -0.002 + 0.0025 * std::sin(t));
  };
  Tally border, frictionless, rings;
  wind(load(plate_model(0.1, 20, uniform(400, 300, 0.2)), options).asset, 0, over_plate, 3, border);
  expect_many(border, {{"slip at a border", 50}});
  wind(load(plate_model(0.1, 20, uniform(400, 0, 0.2))).asset, 0, over_plate, 4, frictionless);
  expect_many(frictionless, {{"slip frictionless", 100}});
  Model uneven = plate_model(0.1, 20, uniform(400, 300, 0.3));
  make_rings(
      uneven, 0.5, 0, [](const Vec3& x) { return 1 + 6 * x[0]; },
      [](const Vec3& x) { return Vec3(200, 3000 * x[0], 0); });
  const Loaded plate = load(uneven);
  wind(plate.asset, 0, over_plate, 5, rings);
  wind(
      plate.asset, 0.004, [&](double t) { return Vec3(over_plate(t) + Vec3(0, 0, 0.004)); }, 6,
      rings);
  expect_many(rings, {{"stick", 100}, {"slip", 500}});
}

TEST(tangent, of_a_contact_in_debt_is_the_derivative_while_it_sticks_and_finite_in_a_slip) {
  Tally tally;
  const Loaded plate = load(plate_model(0.1, 40, [](const Vec3& x) {
    const double k = 400 * (1 + 8 * x[0]);
    return PointCurves{[=](double d) { return k * d; }, [](double d) { return 300 * d; },
                       [=](double d) { return 0.005 * k * d; }};
  }));
  wind(
      plate.asset, 0,
      [](double t) {  // from soft to stiff, and back through the air
        const double share = std::fmod(0.05 * t, 1.0);
        const bool is_down = share > 0.005 && share < 0.995;
        return Vec3(-0.035 + 0.07 * share, 0.0007,
                    is_down ? -0.003 + 0.0002 * std::sin(70 * t) : 0.001);
      },
      7, tally);
  expect_many(tally, {{"slip held back", 200}, {"stick held back", 20}});
}

TEST(tangent, in_a_press_is_the_slope_of_the_curves) {
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 1e6)));
  Contact contact;
  Output out;
  double k[9];
  for (double z : {0.001, -0.001, -0.003}) {
    const double x[3] = {0.001, 0.0013, z};
    touch(plate.asset, contact, x, out, k);
  }
  EXPECT_NEAR(k[8], 400, 1e-4);
  const double aside[3] = {0.0025, 0.0013, -0.003};
  touch(plate.asset, contact, aside, out, k);
  EXPECT_NEAR(k[0], 300, 1e-4);  // along the lateral deflection: f^r'
  EXPECT_NEAR(k[4], 300, 1e-4);  // across it: f^r / dr
  EXPECT_NEAR(k[8], 400, 1e-4);
}

}  // namespace
}  // namespace palpate::test
