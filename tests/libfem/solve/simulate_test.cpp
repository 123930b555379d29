#include <gtest/gtest.h>

#include <cstring>

#include "block.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {
namespace {

/// Three points on top of the block.
TestPoints three_points() {
  TestPoints points;
  points.position.resize(3, 3);
  points.normal.resize(3, 3);
  for (int p = 0; p < 3; ++p) {
    points.position.row(p) = (block_top() + p * Vec3(-0.006, 0.007, 0)).transpose();
    points.normal.row(p) = -Vec3::UnitZ().transpose();
    points.name.push_back(std::string(1, static_cast<char>(0x61 + p)));
  }
  return points;
}

const Simulator& simulator() {
  static const Simulator one(block_setup(0.3));
  return one;
}

/// One press and a drag of two rows.
Experiments short_experiments() {
  Experiments experiments = press_and_one_drag();
  experiments.press_steps = 2;
  experiments.drag_steps = 1;
  experiments.drag_distance_m = 0.001;
  return experiments;
}

// Bit for bit, also where a number is NaN.
void expect_same(const Samples& a, const Samples& b) {
  const auto same = [&](const char* name, auto column, auto&&...) {
    const auto &x = a.*column, &y = b.*column;
    ASSERT_EQ(x.size(), y.size()) << name;
    if constexpr (std::is_trivially_copyable_v<std::remove_cvref_t<decltype(*x.data())>>) {
      EXPECT_EQ(std::memcmp(x.data(), y.data(), sizeof *x.data() * x.size()), 0) << name;
    }
  };
  each_point_column(same);
  each_row_column(same);
}

const Samples& uninterrupted() {
  static const Samples samples = simulate(simulator(), experiments_at(three_points()),
                                          short_experiments(), {.jobs = 1, .already_done = {}});
  return samples;
}

TEST(Simulate, one_and_two_threads_give_the_same_bits) {
  ASSERT_EQ(uninterrupted().rows(), 9);
  for (const RowStatus status : uninterrupted().status) EXPECT_EQ(status, RowStatus::good);
  EXPECT_EQ(uninterrupted().experiment, (std::vector<std::int32_t>{0, 0, 1, 2, 2, 3, 4, 4, 5}));
  expect_same(uninterrupted(), simulate(simulator(), experiments_at(three_points()),
                                        short_experiments(), {.jobs = 2, .already_done = {}}));
}

TEST(Simulate, a_stopped_run_keeps_finished_points_and_resumes_to_the_same_bits) {
  bool stop = false;
  std::size_t reported = 0;
  Progress progress;
  progress.is_stopped = [&] { return stop; };
  progress.step = [&](std::size_t done, std::size_t total, const std::string&) {
    EXPECT_EQ(total, 3u);
    reported = done;
  };
  Samples saved;
  const Samples stopped = simulate(
      simulator(), experiments_at(three_points()), short_experiments(),
      {.jobs = 1, .already_done = {}},
      [&](const std::function<Samples()>& so_far) {
        saved = so_far();
        stop = true;
      },
      progress);
  EXPECT_EQ(reported, 1u);
  ASSERT_EQ(stopped.rows(), 3) << "the finished point and nothing else";
  expect_same(stopped, saved);

  int simulated = 0;
  const Samples resumed = simulate(simulator(), experiments_at(three_points()), short_experiments(),
                                   {.jobs = 1, .already_done = saved},
                                   [&](const std::function<Samples()>&) { ++simulated; });
  EXPECT_EQ(simulated, 2);
  expect_same(resumed, uninterrupted());
}

TEST(Simulate, a_point_stopped_half_way_leaves_no_rows) {
  int polls = 0;
  Progress progress;
  progress.is_stopped = [&] { return ++polls > 2; };
  const Samples stopped = simulate(simulator(), experiments_at(three_points()), short_experiments(),
                                   {.jobs = 1, .already_done = {}}, {}, progress);
  EXPECT_EQ(stopped.rows(), 0);
  EXPECT_EQ(stopped.points(), 3);
}

// (M13e): of a body whose points are alike, what one mesh lacks is the same everywhere.
TEST(Simulate, a_press_on_one_mesh_is_that_on_two_but_for_a_factor_of_the_body) {
  SimulationSetup setup = block_setup(0.3);
  setup.options.coarse_ratio = 1.6;
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  const Simulator with_error(setup);
  const TestPoints points = three_points();
  const Experiments experiments = short_experiments();
  const std::vector<Effort> pressed(3);
  const Samples full =
      simulate(with_error, experiments_at(points, pressed), experiments, {.jobs = 1});
  SimulateOptions one_mesh{.jobs = 1};
  const Samples raw =
      simulate(with_error, experiments_at(points, {3, Effort{false, 1}}), experiments, one_mesh);
  ASSERT_EQ(raw.rows(), 6);
  EXPECT_EQ(raw.point_scale, Eigen::VectorXd::Ones(3));
  EXPECT_TRUE(raw.force_error.array().isNaN().all()) << "an error that nobody knows";
  const QuickScale quick = compare_quick(full, raw);
  EXPECT_GT(quick.number(), 0.9);
  EXPECT_LT(quick.number(), 1) << "a coarse mesh is too stiff";
  EXPECT_LT(quick.p95, 0.02);
  ASSERT_EQ(quick.steps.size(), 2u);

  one_mesh.quick = quick;
  const Samples scaled =
      simulate(with_error, experiments_at(points, {3, Effort{false, quick.number()}}), experiments,
               one_mesh);
  EXPECT_NE(scaled.point_sway.norm(), 0) << "as points on two meshes";
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    ASSERT_EQ(scaled.step[i], full.step[i]);
    EXPECT_LT((scaled.force.row(i) - full.force.row(i)).norm(), scaled.force_error[i]);
    EXPECT_LT(scaled.force_error[i], 0.05 * scaled.force.row(i).norm());
  }
}

TEST(Simulate, presses_without_a_row_in_common_tell_no_factor) {
  Samples failed = uninterrupted();
  std::fill(failed.status.begin(), failed.status.end(), RowStatus::rejected);
  EXPECT_FALSE(compare_quick(failed, uninterrupted()));
}

TEST(Simulate, a_path_repeats_the_press_it_describes) {
  ToolPath path;
  path.deflections.resize(2, 3);
  path.deflections << 0, 0, -0.002, 0, 0, -0.004;
  const Samples samples =
      simulate(simulator(), paths_at(three_points(), {path}), short_experiments(), {.jobs = 1});
  ASSERT_EQ(samples.rows(), 2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(samples.kind[i], ExperimentKind::path);
    EXPECT_EQ(samples.status[i], RowStatus::good);
    // Another mesh (no drag to refine for), so only the physics agrees.
    const Vec3 press = uninterrupted().force.row(i), again = samples.force.row(i);
    EXPECT_LT((press - again).norm(), 0.05 * press.norm()) << i;
  }
}

}  // namespace
}  // namespace palpate::fem
