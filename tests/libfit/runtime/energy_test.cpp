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

TEST(energy, closed_loops_at_a_fixed_contact_do_no_work) {
  // Linear curves of one piece and no slip: the trapezoid rule is exact along straight ways only
  // for a quadratic energy, which this is.
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 1e6)));
  Tool tool(plate.asset);
  tool.go({0, 0.001, 0.001}, {0, 0.001, -0.002}, 1e-4);
  Work work{tool, {0, 0.001, -0.002}, tool.tick({0, 0.001, -0.002})};
  double path_J = 0;
  for (const Vec3& corner : {Vec3(0.004, 0.001, -0.003), Vec3(0.002, 0.006, -0.001),
                             Vec3(-0.003, 0.004, -0.004), Vec3(0, 0.001, -0.002)}) {
    const double start_J = work.sum_J;
    work.go(corner, 1e-5);
    path_J += std::abs(work.sum_J - start_J);
    EXPECT_EQ(tool.out.state, ContactState::stick);
  }
  EXPECT_GT(path_J, 1e-3);
  EXPECT_LT(std::abs(work.sum_J), 1e-9 * path_J);
}

TEST(energy, stored_energy_is_the_work_at_a_fixed_contact) {
  ExportOptions options;
  options.fades_borders = false;
  const Loaded cylinder = load(cylinder_model(), options);
  Tool tool(cylinder.asset);
  const Vec3 out(std::cos(0.4), std::sin(0.4), 0);
  tool.tick(out * 0.031 + Vec3(0, 0, 0.033));
  Work work{tool, out * 0.031 + Vec3(0, 0, 0.033)};
  work.go(out * 0.026 + Vec3(0, 0, 0.033), 1e-6);
  EXPECT_GT(tool.out.stored_J, 5e-4);
  EXPECT_NEAR(work.sum_J, tool.out.stored_J + tool.out.dissipated_J, 1e-6 * work.sum_J);
}

TEST(energy, work_of_a_slide_is_stored_plus_dissipated) {
  const Loaded plate = load(plate_model(0.1, 20, uniform(400, 300, 0.4)));
  Tool tool(plate.asset);
  tool.tick({-0.02, 0.001, 0.001});
  Work work{tool, {-0.02, 0.001, 0.001}};
  work.go({-0.02, 0.001, -0.003}, 1e-5);
  work.go({0.02, 0.004, -0.003}, 1e-5);
  // A tick of h lets f^r overshoot L by k_r h before it slips: the ledger is ahead by k_r h / 2 L.
  const double ahead = 300 * 1e-5 / (2 * 0.48);
  EXPECT_NEAR(work.sum_J * (1 + ahead), tool.out.stored_J + tool.out.dissipated_J,
              0.2 * ahead * work.sum_J);
  work.go({0.02, 0.004, 0.001}, 1e-5);
  EXPECT_EQ(tool.out.state, ContactState::air);
  EXPECT_NEAR(work.sum_J * (1 + ahead), tool.out.dissipated_J, 0.2 * ahead * work.sum_J);
  EXPECT_NEAR(tool.out.dissipated_J, 0.4 * 1.2 * 0.04, 0.05 * 0.4 * 1.2 * 0.04);
  EXPECT_EQ(tool.out.refused_J, 0);
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

TEST(energy, slips_never_raise_what_is_stored_and_laid_by) {
  const Loaded cylinder = load(cylinder_model());
  Tool tool(cylinder.asset);
  double before_J = 0;
  tool.tick({0.035, 0.012, 0.05});
  for (int tick = 0; tick < 20000; ++tick) {
    const double t = tick * 1e-3, angle = 0.4 + 0.7 * std::sin(3 * t),
                 radius = 0.0275 + 0.002 * std::sin(1.7 * t);
    tool.tick(
        {radius * std::cos(angle), radius * std::sin(angle), 0.05 + 0.02 * std::sin(2.3 * t)});
    const double lost_J = tool.out.dissipated_J - tool.contact.ledger.tank_J;
    ASSERT_GE(lost_J, before_J * (1 - 1e-15) - 1e-16) << tick;
    before_J = lost_J;
  }
  EXPECT_GT(before_J, 1e-3);
}

}  // namespace
}  // namespace palpate::test
