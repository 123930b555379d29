// What every row of the table of curve families keeps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/series/quadric_replay.hpp"
#include "tests/support/from_touch.hpp"

namespace palpate::test {
namespace {

constexpr double kRange_m = 0.01;

// A node with admissible numbers of every part.
struct Node {
  std::vector<SplineTables> tables;
  std::vector<std::vector<double>> numbers;
  runtime::CurveViews views;
  runtime::ControlPointers<double> controls{};

  Node(CurveFamily family, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> draw(0.5, 1.5);
    views.family = static_cast<int>(family);
    const auto parts = parts_of(family);
    tables.resize(parts.size()), numbers.resize(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const CurveBasis basis{3, {0, 0.4 * kRange_m, kRange_m}};
      if (parts[i].is_curve()) {
        tables[i] = tabulate(basis);
        views.view[i] = {tables[i].degree, tables[i].pieces, tables[i].knots.data(),
                         tables[i].weights.data(), tables[i].integrals.data()};
      }
      const int count = parts[i].width * size_of(parts[i], basis);
      for (int j = 0; j < count; ++j) {
        const bool is_zero = parts[i].starts_at_zero && j < parts[i].width;
        const double unit = std::pow(kRange_m, parts[i].length);
        const double middle = parts[i].min < 0 ? 1 : 0;
        const double step = parts[i].rises ? draw(random) : 0.2 * unit * (draw(random) - middle);
        const double below = parts[i].rises && j > 0 ? numbers[i].back() : 0;
        numbers[i].push_back(is_zero ? 0 : std::clamp(below + step, parts[i].min, parts[i].max));
      }
      controls.part[i] = numbers[i].data();
    }
    prepare(views);
  }
  runtime::QuadricSpot<double, double, false> spot() const {
    static const runtime::Quadric kFlat{{0, 0, 1}, {}};
    return runtime::QuadricSurface<double>{&kFlat, controls, {0, 0, 0}}.standing();
  }
};

TEST(families, names_are_told_apart_and_the_rising_curves_come_first) {
  for (const CurveFamilyName& row : kCurveFamilyNames) {
    for (const CurveFamilyName& other : kCurveFamilyNames)
      EXPECT_EQ(row.name == other.name, row.family == other.family);
    for (std::size_t kind = 0; kind < curves_of(row.family); ++kind) {
      EXPECT_EQ(parts_of(row.family)[kind].name, kCurveNames[kind]) << row.name;
      EXPECT_TRUE(parts_of(row.family)[kind].rises) << row.name;
    }
  }
}

TEST(families, force_is_the_gradient_of_the_stored_energy) {
  for (const CurveFamilyName& row : kCurveFamilyNames)
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Node node(row.family, seed);
      const auto spot = node.spot();
      std::mt19937 random(100 + seed);
      std::uniform_real_distribution<double> share(0.1, 0.9);
      const runtime::Vec3d x{kRange_m * share(random), -kRange_m * share(random),
                             kRange_m * share(random)};
      const auto energy_J = [&](const runtime::Vec3d& at) {
        return test::energy_from_touch_J(node.views, spot, at);
      };
      const auto force = test::force_from_touch(node.views, spot, x);
      const double size = std::sqrt(dot(force, force)), step = 1e-7;
      const double found[3] = {force.x, force.y, force.z};
      for (int k = 0; k < 3; ++k) {
        const runtime::Vec3d off{k == 0 ? step : 0, k == 1 ? step : 0, k == 2 ? step : 0};
        EXPECT_NEAR((energy_J(x + off) - energy_J(x - off)) / (2 * step), found[k], 1e-6 * size)
            << row.name << ", seed " << seed << ", direction " << k;
      }
    }
}

TEST(families, a_number_out_of_its_bounds_is_not_good) {
  for (const CurveFamilyName& row : kCurveFamilyNames) {
    const Node node(row.family, 7);
    const auto parts = parts_of(row.family);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto is_good = [&](const std::vector<double>& numbers, bool is_zero) {
        return runtime::is_good_part(parts[i], numbers.data(),
                                     static_cast<int>(numbers.size()) / parts[i].width, is_zero);
      };
      std::vector<double> numbers = node.numbers[i];
      EXPECT_TRUE(is_good(numbers, false)) << row.name << ' ' << parts[i].name;
      EXPECT_FALSE(is_good(numbers, true)) << row.name << ' ' << parts[i].name;
      numbers.back() = 2 * parts[i].max;
      EXPECT_FALSE(is_good(numbers, false)) << row.name << ' ' << parts[i].name;
      numbers.back() = std::numeric_limits<double>::quiet_NaN();
      EXPECT_FALSE(is_good(numbers, false)) << row.name << ' ' << parts[i].name;
    }
  }
}

}  // namespace
}  // namespace palpate::test
