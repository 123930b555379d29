// The force of a bed of rings is the gradient of its energy, and its slips only lose energy.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/libfit/runtime/flat_rings.hpp"

namespace palpate::runtime {
namespace {

// Work of the tool at anchors held during each move, the law's own energy, not the sampling's.
TEST(Rings, closed_loops_create_no_energy_at_any_tick_length) {
  const Quadratic quadratic;
  const Concave concave;
  constexpr std::uint64_t kSeed = 31;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform;
  for (int loop = 0; loop < 300; ++loop) {
    const Curve& curve = loop % 3 == 2 ? static_cast<const Curve&>(concave) : quadratic;
    Numbers numbers;  // flat and even
    const double friction = std::pow(10, -3 * uniform(random));
    numbers.friction *= friction;
    numbers.slope *= friction;
    Bench bench(curve, numbers);
    const double step_m = std::pow(10, -6 + 4 * uniform(random));  // 1 um to 1 cm
    double work_J = 0, moved_J = 0;
    Vec3d x{0, 0, 0};
    double stored_J = 0;
    for (int leg = 0; leg < 7; ++leg) {
      const Vec3d to = leg == 6 ? Vec3d{0, 0, 1e-4}
                                : Vec3d{5e-3 * (2 * uniform(random) - 1),
                                        5e-3 * (2 * uniform(random) - 1), -7e-3 * uniform(random)};
      const int ticks = std::clamp(static_cast<int>(size(to - x) / step_m), 1, 1000);
      const Vec3d from = x;
      for (int k = 1; k <= ticks; ++k) {
        x = from + (to - from) * (double(k) / ticks);
        const double held_J = bench.answer(x).stored_J;
        work_J += held_J - stored_J;
        moved_J += std::fabs(held_J - stored_J);
        stored_J = bench.go(x).stored_J;
        EXPECT_LE(stored_J, held_J + 1e-15) << "seed " << kSeed << " loop " << loop;
      }
    }
    EXPECT_LT(stored_J, 1e-30);
    EXPECT_GT(work_J, -1e-13 * moved_J) << "seed " << kSeed << " loop " << loop;
  }
}

TEST(Rings, force_has_no_jump_where_rings_attach_or_release) {
  const Quadratic curve;
  Bench bench(curve);
  bench.go(0, 0, 7e-3);
  bench.go(2e-3, 1e-3, 7e-3);
  // Steepest: f^z' with all of friction.
  const double stiffness = 2 * (12 + 9000 * kDepth_m), step = 1e-7;
  Vec3d before = bench.go(2e-3, 1e-3, 7e-3).force_N;
  double largest = 0;
  for (int way = -1; way <= 1; way += 2)
    for (int k = 0; k <= 70000; ++k) {  // out of contact and back
      const double depth = way < 0 ? 7e-3 - step * k : step * k;
      const Vec3d force = bench.go(2e-3, 1e-3 + 0.01 * step * k, depth).force_N;
      largest = std::max(largest, size(force - before));
      before = force;
    }
  EXPECT_LT(largest, stiffness * step);
}

}  // namespace
}  // namespace palpate::runtime
