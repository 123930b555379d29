// Work over closed ways, the ledger of slips, and the guard.

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

// Work done on the body along straight ways, by the trapezoid rule over ticks.
struct Work {
  Tool& tool;
  Vec3 before_m, before_N = Vec3::Zero();
  double sum_J = 0;
  void go(const Vec3& to_m, double step_m) {
    const Vec3 from_m = before_m;
    const int steps = std::max(1, static_cast<int>(std::ceil((to_m - from_m).norm() / step_m)));
    for (int i = 1; i <= steps; ++i) {
      const Vec3 x = from_m + (to_m - from_m) * (double(i) / steps), f = tool.tick(x);
      sum_J += 0.5 * (f + before_N).dot(x - before_m);
      before_m = x;
      before_N = f;
    }
  }
};

std::function<PointCurves(const Vec3&)> soft_to_stiff(double mu) {
  return [=](const Vec3& x) {
    const double k = 400 * (1 + 8 * x[0]);  // along x: 0.6 to 1.4 times 400 N/m
    return PointCurves{[=](double d) { return k * d; }, [](double d) { return 300 * d; },
                       [=](double d) { return mu * k * d; }};
  };
}

// Press where it is soft, slide to where it is stiff, lift: work done on the body.
double soft_to_stiff_work_J(double mu, bool has_guard, Contact* contact, double step_m = 1e-5) {
  Loaded plate = load(plate_model(0.1, 40, soft_to_stiff(mu)));
  plate.asset.has_guard = has_guard;
  Tool tool(plate.asset);
  const Vec3 start(-0.03, 0.0007, 0.001), end(0.03, 0.0011, 0.001), down(0, 0, -0.004);
  tool.tick(start);
  Work work{tool, start};
  work.go(start + down, 1e-5);
  work.go(end + down, step_m);
  work.go(end, 1e-5);
  EXPECT_EQ(tool.contact.triangle, -1);
  if (contact) *contact = tool.contact;
  return work.sum_J;
}

TEST(energy, the_published_rule_creates_energy_and_the_guard_refuses_it) {
  const double created_J =
      0.5 * 400 * 8 * 0.06 * 0.003 * 0.003;  // F(stiff) - F(soft) stored at 3 mm
  Contact without, with;
  const double work_J = soft_to_stiff_work_J(0, false, &without);
  EXPECT_NEAR(work_J, -created_J, 0.02 * created_J);
  EXPECT_EQ(without.ledger.refused_ticks, 0);
  const double guarded_J = soft_to_stiff_work_J(0, true, &with, 1e-6);
  // The guard snaps at mu = 0, and the trapezoid rule errs by a snap times a step.
  EXPECT_GT(guarded_J, -0.02 * created_J);
  EXPECT_GT(with.ledger.refused_ticks, 100);
  EXPECT_GT(with.ledger.refused_J, 0);
}

TEST(energy, the_guard_never_acts_where_friction_suffices) {
  // Least friction by the rule of thumb: (dz / 2) |d ln k / ds| = 0.0015 * 8 / 0.76 = 0.016.
  Contact contact;
  EXPECT_GT(soft_to_stiff_work_J(0.05, true, &contact), 0);
  EXPECT_EQ(contact.ledger.refused_ticks, 0);
  EXPECT_EQ(contact.ledger.refused_J, 0);
}

// A damaged asset's energies once made the sums NaN for good.
TEST(energy, that_is_no_number_leaves_the_sums_numbers_and_no_force) {
  runtime::Ledger ledger;
  ledger.book(2e-3, 1e-3, true);
  const double dissipated_J = ledger.dissipated_J;
  ledger.book(std::numeric_limits<double>::quiet_NaN(), 1e-3, true);
  EXPECT_EQ(ledger.dissipated_J, dissipated_J);
  EXPECT_EQ(ledger.share(1e-3), 0);
  ledger.close(std::numeric_limits<double>::infinity());
  EXPECT_EQ(ledger.dissipated_J, dissipated_J);
}

}  // namespace
}  // namespace palpate::test
