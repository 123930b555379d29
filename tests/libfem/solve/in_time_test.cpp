#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "block.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward = -Vec3::UnitZ();

Relaxation one_branch(double share, double time_s) {
  return {Eigen::VectorXd::Constant(1, share), Eigen::VectorXd::Constant(1, time_s)};
}

/// A press to depth_m at constant speed in `rows` rows that takes press_s, then a hold.
ToolPath press_and_hold(double depth_m, int rows, double press_s,
                        const std::vector<double>& hold_s) {
  ToolPath path;
  const auto count = static_cast<Eigen::Index>(rows + hold_s.size());
  path.deflections.resize(count, 3);
  path.time_s.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    path.deflections.row(i) = depth_m * std::min(1.0, double(i + 1) / rows) * kInward.transpose();
    path.time_s[i] = i < rows ? press_s * double(i + 1) / rows : press_s + hold_s[i - rows];
  }
  return path;
}

/// Force [N] along the press in slow motion, between rows as force over depth^{3/2} is linear.
class SlowCurve {
 public:
  SlowCurve(const PointRows& press) {
    for (Eigen::Index row = 0; row < press.rows(); ++row) {
      depth_.push_back(press.deflection.row(row).dot(kInward));
      over_.push_back(press.force.row(row).dot(kInward) / std::pow(depth_.back(), 1.5));
    }
  }
  double operator()(double d) const {
    if (d <= depth_[0]) return over_[0] * std::pow(std::max(d, 0.0), 1.5);
    std::size_t i = 1;
    while (i + 1 < depth_.size() && depth_[i] < d) ++i;
    const double t = (d - depth_[i - 1]) / (depth_[i] - depth_[i - 1]);
    return (over_[i - 1] + t * (over_[i] - over_[i - 1])) * std::pow(d, 1.5);
  }

 private:
  std::vector<double> depth_, over_;
};

/// Lee and Radok 1960: f and the hereditary integral of its rate, at each row of a path.
std::vector<double> hereditary(const SlowCurve& f, const ToolPath& path, const Relaxation& series) {
  std::vector<double> out;
  double t0 = 0, d0 = 0, before = 0;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(series.branches());
  for (Eigen::Index i = 0; i < path.time_s.size(); ++i) {
    const double t1 = path.time_s[i], d1 = path.deflections.row(i).dot(kInward);
    constexpr int kPieces = 400;
    for (int k = 1; k <= kPieces; ++k) {
      const double now = f(d0 + (d1 - d0) * k / kPieces), dt = (t1 - t0) / kPieces;
      for (Eigen::Index b = 0; b < q.size(); ++b)
        q[b] = std::exp(-dt / series.time_s[b]) * q[b] +
               series.share[b] * std::exp(-dt / 2 / series.time_s[b]) * (now - before);
      before = now;
    }
    out.push_back(before + q.sum());
    t0 = t1;
    d0 = d1;
  }
  return out;
}

SimulationSetup block(double poisson, const Relaxation& relaxation) {
  SimulationSetup setup = block_setup(0);
  setup.materials = {{"neo-hookean", {kYoung_Pa, poisson}, relaxation}};
  return setup;
}

/// Largest difference of a timed press from what is expected, over what is expected there.
double largest_difference(const PointRows& rows, const std::vector<double>& expected) {
  double worst = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    EXPECT_EQ(rows.status[i], RowStatus::good) << i;
    worst = std::max(worst, std::abs(rows.force.row(i).dot(kInward) / expected[i] - 1));
  }
  return worst;
}

const std::vector<double> kHold_s{0.02, 0.05, 0.1, 0.2, 0.5, 1, 2};

SlowCurve slow_curve(const Simulator& simulator, double depth_m) {
  return simulator.follow(block_top(), kInward,
                          {0, press_and_hold(depth_m, 12, 1, {}).deflections});
}

// nu 0: all of the body relaxes alike, and in small strain a ball's force is the hereditary
// integral of its slow curve. What is left of a deep press is geometry.
TEST(InTime, ramp_and_hold_of_a_ball_is_the_hereditary_integral_of_its_slow_curve) {
  const Relaxation series = one_branch(1, 0.2);
  const Simulator simulator(block(0, series));
  using Bounds = std::vector<std::pair<double, double>>;  // by the time of the press [s]
  for (const auto& [depth_m, bounds] :
       {std::pair(0.0002, Bounds{{0.02, 0.002}, {0.2, 0.004}}), {0.004, Bounds{{2.0, 0.02}}}}) {
    const SlowCurve f = slow_curve(simulator, depth_m);
    for (const auto& [press_s, bound] : bounds) {
      const ToolPath path = press_and_hold(depth_m, 6, press_s, kHold_s);
      EXPECT_LT(largest_difference(simulator.follow(block_top(), kInward, path),
                                   hereditary(f, path, series)),
                bound)
          << depth_m << " " << press_s;
    }
  }
}

// The bulk does not relax: with the material's own series forces are 4 to 7 % off.
TEST(InTime, the_series_of_a_contact_is_weaker_and_slower_than_that_of_its_material) {
  constexpr double kDepth_m = 0.002;
  const Relaxation series = one_branch(1, 0.2);
  const SimulationSetup setup = block(kPoisson, series);
  const Simulator simulator(setup);
  Experiments press = press_only(3);
  press.depth_m = kDepth_m;
  const double at_first = force_at_first(simulator, one_point(), press);
  const Material material = make_material(setup.materials[0], "test");
  const Relaxation half_space = relaxation_of_contact(material);
  EXPECT_NEAR((at_first - 1) / half_space.share[0], 1, 0.04);  // a block
  EXPECT_GT(half_space.time_s[0], series.time_s[0]);
  const Relaxation contact = relaxation_of_contact(material, at_first);
  EXPECT_NEAR(contact.share.sum(), at_first - 1, 1e-12);
  const SlowCurve f = slow_curve(simulator, kDepth_m);
  for (const double press_s : {0.02, 2.0}) {
    const ToolPath path = press_and_hold(kDepth_m, 6, press_s, kHold_s);
    const PointRows rows = simulator.follow(block_top(), kInward, path);
    EXPECT_LT(largest_difference(rows, hereditary(f, path, contact)), 0.012) << press_s;
    EXPECT_GT(largest_difference(rows, hereditary(f, path, series)), 0.03) << press_s;
  }
}

// Three branches against the function that they stand for: E*(P) / E*(0) on the real axis.
TEST(InTime, the_series_of_a_contact_has_the_plane_modulus_of_the_half_space) {
  for (const char* law : {"neo-hookean", "neo-hookean-isochoric"}) {
    Relaxation series{Eigen::Vector3d(0.4, 0.3, 0.5), Eigen::Vector3d(0.05, 0.6, 8)};
    const Material material = make_material({law, {kYoung_Pa, kPoisson}, series}, "test");
    const Relaxation contact = relaxation_of_contact(material);
    const SmallStrain at_rest = material.law->small_strain(material.constants);
    double U, U1, U2;
    material.law->volumetric(material.constants, 0, U, U1, U2);
    const auto plane = [&](double s) {
      const double mu = s * at_rest.mu_Pa, K = U2 + s * (at_rest.bulk_Pa() - U2);
      return 4 * mu * (3 * K + mu) / (3 * K + 4 * mu);
    };
    const auto stiffness = [](const Relaxation& of, double P) {
      return 1 + (of.share.array() * (P * of.time_s.array()) / (1 + P * of.time_s.array())).sum();
    };
    EXPECT_NEAR(stiffness(contact, 1e9) / (plane(2.2) / plane(1)), 1, 1e-8) << law;
    for (const double P : {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0})
      EXPECT_NEAR(stiffness(contact, P) / (plane(stiffness(series, P)) / plane(1)), 1, 2e-3)
          << law << " " << P;
    EXPECT_LT(contact.share.sum(), series.share.sum());
  }
}

TEST(InTime, slow_and_fast_motion_are_elastic_with_long_term_and_first_moduli) {
  // K relaxes with nothing here: constants of the law are mu and lambda, of which mu relaxes.
  const double mu = kYoung_Pa / (2 * (1 + kPoisson));
  const double lambda = 2 * mu * kPoisson / (1 - 2 * kPoisson);
  const double young = 3 * mu * (3 * lambda + 6 * mu) / (lambda + 3 * mu);
  SimulationSetup fast_elastic = block_setup(0), slow_elastic = block_setup(0);
  fast_elastic.materials = {{"neo-hookean", {young, lambda / (2 * (lambda + 3 * mu))}}};
  const Simulator simulator(block(kPoisson, one_branch(2, 0.2)));
  for (const bool is_fast : {true, false}) {
    const ToolPath path = press_and_hold(0.003, 5, is_fast ? 1e-6 : 1e4, {});
    const PointRows rows = simulator.follow(block_top(), kInward, path);
    const PointRows elastic = Simulator(is_fast ? fast_elastic : slow_elastic)
                                  .follow(block_top(), kInward, {0, path.deflections});
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      // The share of U that an element averages is that of slow motion; the mesh is coarse.
      EXPECT_NEAR(rows.force.row(i).dot(kInward) / elastic.force.row(i).dot(kInward), 1,
                  is_fast ? 0.01 : 0.003)
          << is_fast << " " << i;
      EXPECT_EQ(rows.time_s[i], path.time_s[i]);
      EXPECT_EQ(elastic.time_s.size(), 0);
    }
  }
}

TEST(InTime, a_body_that_does_not_relax_feels_no_time) {
  const Simulator simulator(block_setup(0.3));
  const ToolPath path = press_and_hold(0.003, 3, 0.1, {0.1});
  const PointRows timed = simulator.follow(block_top(), kInward, path);
  const PointRows slow = simulator.follow(block_top(), kInward, {0, path.deflections});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(timed.force.row(i), slow.force.row(i));
  EXPECT_LT((timed.force.row(3) - timed.force.row(2)).norm(), 1e-3 * timed.force.row(2).norm());
}

// Tissue springs back more slowly than the tool leaves: contact shrinks, and nothing pulls.
TEST(InTime, a_tool_that_leaves_fast_is_never_pulled_and_lets_go_early) {
  const Simulator simulator(block(kPoisson, one_branch(2, 0.2)));
  ToolPath path = press_and_hold(0.004, 4, 0.1, {1});
  const Eigen::Index pressed = path.time_s.size(), rows = pressed + 8;
  path.deflections.conservativeResize(rows, 3);
  path.time_s.conservativeResize(rows);
  for (Eigen::Index i = pressed; i < rows; ++i) {
    path.deflections.row(i) =
        0.004 * (1 - 0.95 * double(i - pressed + 1) / 8) * kInward.transpose();
    path.time_s[i] = path.time_s[i - 1] + 0.005;
  }
  const PointRows result = simulator.follow(block_top(), kInward, path);
  double before = kYoung_Pa;
  bool has_let_go = false;
  for (Eigen::Index i = pressed; i < rows; ++i) {
    ASSERT_EQ(result.status[i], RowStatus::good) << i;
    EXPECT_GE(result.force.row(i).dot(kInward), 0) << i;
    EXPECT_LE(result.force.row(i).dot(kInward), before) << i;
    before = result.force.row(i).dot(kInward);
    has_let_go |= before == 0;
  }
  EXPECT_TRUE(has_let_go);
}

TEST(InTime, what_time_steps_leave_is_of_second_order) {
  SimulationSetup setup = block(kPoisson, one_branch(2, 0.05));
  setup.options.equilibrium.residual = 1e-6;
  const Simulator simulator(setup);
  // A press that goes on from rest, in equal steps of 1 to 0.25 of the branch's time.
  const auto force_after = [&](int steps) {
    ToolPath path = press_and_hold(0.003, 4, 0.05, {0.5});
    const Eigen::Index before = path.time_s.size();
    path.deflections.conservativeResize(before + steps, 3);
    path.time_s.conservativeResize(before + steps);
    for (Eigen::Index i = 0; i < steps; ++i) {
      path.deflections.row(before + i) =
          (0.003 + 0.002 * double(i + 1) / steps) * kInward.transpose();
      path.time_s[before + i] = path.time_s[before - 1] + 0.1 * double(i + 1) / steps;
    }
    return simulator.follow(block_top(), kInward, path)
        .force.bottomRows<1>()
        .dot(kInward.transpose());
  };
  const double at_2 = force_after(2), at_4 = force_after(4), at_8 = force_after(8);
  EXPECT_NEAR(std::log2((at_4 - at_2) / (at_8 - at_4)), 2, 0.3);
  EXPECT_LT(std::abs(at_8 - at_4) / at_8, kStepError / 2);
}

TEST(InTime, a_path_in_time_has_its_speed_and_a_hold) {
  ToolPath path{3, Points::Zero(3, 3), {}};
  path.deflections.row(0) = 0.003 * kInward.transpose();
  path.deflections.row(1) = Vec3(0.004, 0, -0.003).transpose();
  path.deflections.row(2) = path.deflections.row(1);  // stands still: no row
  const ToolPath timed = in_time(path, 0.01, 2);
  ASSERT_EQ(timed.time_s.size(), 2 + kHoldRows);
  EXPECT_EQ(timed.point, 3);
  EXPECT_NEAR(timed.time_s[0], 0.3, 1e-12);
  EXPECT_NEAR(timed.time_s[1], 0.7, 1e-12);
  EXPECT_NEAR(timed.time_s[2], 0.72, 1e-12);
  EXPECT_NEAR(timed.time_s[1 + kHoldRows], 2.7, 1e-12);
  for (int k = 0; k < kHoldRows; ++k)
    EXPECT_EQ(timed.deflections.row(2 + k), path.deflections.row(1));
  EXPECT_EQ(in_time(path, 0.01, 0).time_s.size(), 2);
}

}  // namespace
}  // namespace palpate::fem
