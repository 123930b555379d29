// Where recordings lie on the body, and what becomes of several of one point.

#include "libfit/recordings/placing/assemble.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "libfit/core/error.hpp"
#include "tests/support/surfaces.hpp"

namespace palpate::recordings {
namespace {

constexpr unsigned kDrawSeed = 7;

Surface bumpy_sheet() {
  return testing_support::sheet(20, 20, [](double u, double v) {
    const double x = 0.1 * u, y = 0.1 * v;
    return Vec3(x, y, 0.004 * std::sin(60 * x) * std::cos(45 * y) + 0.1 * x * y);
  });
}

RigidMotion some_motion(double angle, double shift_m) {
  return {Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()).toRotationMatrix(),
          shift_m * Vec3(1, -2, 0.5)};
}

TEST(registration, landmarks_give_back_the_motion) {
  const Points from = bumpy_sheet().vertices.topRows(40);
  const RigidMotion truth = some_motion(2.5, 0.3);
  Points to(40, 3);
  for (Eigen::Index i = 0; i < 40; ++i) to.row(i) = truth(from.row(i));
  const Registration found = register_landmarks(from, to);
  EXPECT_LT((found.motion.rotation - truth.rotation).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((found.motion.translation_m - truth.translation_m).norm(), 1e-10);
  EXPECT_LT(found.largest_m, 1e-10);
}

TEST(registration, contact_points_find_the_surface_that_they_lie_on) {
  const Surface surface = bumpy_sheet();
  std::mt19937 random(kDrawSeed);
  Points body(80, 3), rig(80, 3);
  const RigidMotion away = some_motion(0.05, 0.001);
  for (Eigen::Index i = 0; i < 80; ++i) {
    body.row(i) = surface.vertices.row(static_cast<Eigen::Index>(random() % 441));
    rig.row(i) = away.rotation.transpose() * (Vec3(body.row(i)) - away.translation_m);
  }
  const Registration found = register_to_surface(rig, surface, {});
  EXPECT_LT(found.rms_m, 1e-6) << "seed " << kDrawSeed;
  EXPECT_LT((found.motion.rotation - away.rotation).cwiseAbs().maxCoeff(), 1e-4)
      << "seed " << kDrawSeed;
}

TEST(registration, landmarks_on_one_line_are_refused) {
  Points line(4, 3);
  for (int i = 0; i < 4; ++i) line.row(i) << i, 2 * i, 3 * i;
  EXPECT_THROW(register_landmarks(line, line), Error);
}

// Presses of one point, conditioned already: push = stiffness * depth.
Conditioned linear_press(double stiffness_N_m, double speed_m_s) {
  Conditioned r;
  r.is_axial = true;
  r.inward = Vec3(0, 0, -1);
  r.contact_m = Vec3(0.01, 0, 0);
  r.speed_m_s = speed_m_s;
  r.hysteresis = r.young_Pa = std::numeric_limits<double>::quiet_NaN();
  r.apparent_Pa = 1e4;
  r.noise_N = 1e-3;
  r.deflection_m = r.force_N = Points::Zero(20, 3);
  r.error_N = Eigen::VectorXd::Constant(20, 1e-3);
  for (int i = 0; i < 20; ++i) {
    r.deflection_m(i, 0) = 1e-4 * (i + 1);
    r.force_N(i, 0) = stiffness_N_m * r.deflection_m(i, 0);
  }
  r.status.assign(20, RowStatus::good);
  return r;
}

Assembled assembled(const std::vector<Conditioned>& presses, const BatchOptions& options = {},
                    const std::vector<double>& radius_m = {}) {
  std::vector<BatchItem> items(presses.size());
  std::vector<ItemResult> results(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    items[i].file = items[i].shown = "p" + std::to_string(i) + ".csv";
    items[i].point = "p";
    if (!radius_m.empty()) items[i].signal.radius_m = radius_m[i];
    results[i].recordings = {presses[i]};
    results[i].is_done = true;
  }
  return assemble(items, results, options);
}

TEST(pooling, repeats_become_their_mean_and_their_scatter_its_error) {
  const Assembled out =
      assembled({linear_press(900, 1e-3), linear_press(1000, 1e-3), linear_press(1100, 1.05e-3)});
  ASSERT_EQ(out.samples.rows(), 20);
  EXPECT_EQ(out.samples.recordings.experiment, (std::vector<std::int32_t>{0, 0, 0}));
  for (Eigen::Index i = 0; i < 20; ++i) {
    const double depth = -out.samples.deflection(i, 2);
    EXPECT_NEAR(-out.samples.force(i, 2), 1000 * depth, 1e-9);
    EXPECT_NEAR(out.samples.force_error[i], std::hypot(100 * depth, 1e-3), 1e-9);
  }
  EXPECT_TRUE(out.notes.empty());
}

TEST(pooling, rates_are_kept_apart_and_a_difference_beyond_the_noise_is_reported) {
  const Assembled out = assembled({linear_press(1000, 1e-3), linear_press(1300, 1e-2)});
  EXPECT_EQ(out.samples.recordings.experiment, (std::vector<std::int32_t>{0, 1}));
  ASSERT_EQ(out.notes.size(), 1u);
  EXPECT_NE(out.notes[0].find("30 % above that at 1 mm/s"), std::string::npos) << out.notes[0];
  EXPECT_TRUE(assembled({linear_press(1000, 1e-3), linear_press(1001, 1e-2)}).notes.empty());
}

// Of a robot: the tool leans, its encoders jitter and its sensor's frame is off. Contact and normal
// are its own.
Conditioned robot_press(double lean, double force_aside, double jitter_m, unsigned seed) {
  Conditioned r = linear_press(1000, 1e-3);
  r.is_axial = false;
  std::mt19937 random(seed);
  std::normal_distribution<double> draw;
  for (Eigen::Index i = 0; i < r.deflection_m.rows(); ++i) {
    const double depth_m = r.deflection_m(i, 0), push_N = r.force_N(i, 0);
    r.deflection_m.row(i) << lean * depth_m + jitter_m * draw(random), jitter_m * draw(random),
        -depth_m;
    r.force_N.row(i) << force_aside * push_N, 0, -push_N;
  }
  return r;
}

TEST(placing, a_press_of_three_axes_has_the_rows_of_one_axis) {
  const Assembled axis = assembled({linear_press(1000, 1e-3), linear_press(1000, 1e-3)});
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Assembled robot = assembled({robot_press(0.1, 0.05, 1e-7 * seed * seed * seed, seed),
                                       robot_press(-0.1, 0.02, 1e-6, seed + 100)});
    ASSERT_EQ(robot.samples.rows(), axis.samples.rows());
    EXPECT_LT((robot.samples.deflection - axis.samples.deflection).cwiseAbs().maxCoeff(), 1e-15)
        << "seed " << seed;
    EXPECT_LT((robot.samples.force - axis.samples.force).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((robot.samples.force_error - axis.samples.force_error).cwiseAbs().maxCoeff(), 1e-9)
        << "seed " << seed << ": what stands aside is no scatter of the press";
    EXPECT_TRUE(robot.notes.empty());
  }
}

// Their rows tell how curves change with the radius, and a row beside the normal told nothing.
TEST(placing, presses_of_a_second_indenter_are_straight_too) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const double lean = std::tan(0.5 * seed * 3.14159265 / 180);  // to 10 degrees
    std::vector<Conditioned> presses{robot_press(lean, 0.05, 1e-6, seed),
                                     robot_press(-lean, 0.02, 1e-4, seed + 100),
                                     robot_press(lean, 0.05, 1e-7, seed + 200)};
    const Assembled out = assembled(presses, {}, {5e-3, 5e-3, 2e-3});
    ASSERT_EQ(out.tips.size(), 2u);
    EXPECT_EQ(out.tips[0].radius_m, 5e-3) << "most recordings are of it";
    ASSERT_EQ(out.samples.rows(), 40) << "two are repeats of each other, the third is not";
    for (Eigen::Index i = 0; i < 40; ++i) {
      const auto row = static_cast<std::size_t>(i);
      const bool is_second = out.samples.probe_number[row] == 1;
      EXPECT_EQ(out.samples.kind[row], is_second ? ExperimentKind::other : ExperimentKind::press);
      EXPECT_EQ(out.samples.deflection.row(i).head(2).cwiseAbs().maxCoeff(), 0) << "seed " << seed;
    }
    EXPECT_EQ(std::ranges::count(out.samples.probe_number, 1), 20);
  }
}

TEST(placing, a_press_that_slides_sideways_is_named_and_stays) {
  const Assembled out = assembled({robot_press(0.8, 0.3, 0, 1)});
  EXPECT_GT(out.samples.deflection.col(0).maxCoeff(), 1e-3);
  ASSERT_EQ(out.notes.size(), 1u);
  EXPECT_EQ(out.notes[0],
            "presses that move sideways by more than a third of their depth, and feel it, count as "
            "drags; say kind = \"drag\" of them, or correct the normal: p");
}

// Once a file named twice, or copied, made repeats without scatter and points that are none.
TEST(pooling, copies_of_a_recording_are_noted) {
  std::vector<BatchItem> items(4);
  std::vector<ItemResult> results(4);
  for (std::size_t i = 0; i < 4; ++i) {
    items[i].file = items[i].shown = i == 1 ? "p0.csv" : "p" + std::to_string(i) + ".csv";
    items[i].point = i < 2 ? "p" : i == 2 ? "q" : "r";
    results[i].hash = i == 3 ? "other" : "same";
    results[i].recordings = {linear_press(1000, 1e-3)};
    results[i].is_done = true;
  }
  EXPECT_EQ(assemble(items, results, {}).notes,
            (std::vector<std::string>{"p0.csv is named again: its readings count twice",
                                      "p2.csv holds the bytes of p0.csv: points p and q are one "
                                      "recording"}));
  items[1].signal.use = Use::mean;  // read in another way: no copy
  items[2].read.columns.force = {"F2"};
  EXPECT_TRUE(assemble(items, results, {}).notes.empty());
}

TEST(pooling, recordings_off_the_surface_are_refused_with_their_distance) {
  const Surface surface = bumpy_sheet();
  Conditioned off = linear_press(1000, 1e-3);
  off.contact_m = Vec3(0.05, 0.05, 0.03);
  Conditioned on = linear_press(1000, 1e-3);
  on.contact_m = surface.vertices.row(50);
  BatchOptions options;
  options.surface = &surface;
  const Assembled out = assembled({on, off}, options);
  EXPECT_FALSE(out.outcomes[0].failure);
  ASSERT_TRUE(out.outcomes[1].failure);
  EXPECT_NE(out.outcomes[1].failure->fact().find("mm from the surface"), std::string::npos);
  EXPECT_LT(out.outcomes[0].surface_distance_m, 1e-12);
}

TEST(plausible, the_likely_unit_is_named) {
  EXPECT_EQ(likely_unit(1e7, 1e4, "N", "mm", true)->unit, "mN");
  EXPECT_EQ(likely_unit(1e1, 1e4, "mN", "mm", true)->unit, "N");
  const auto length = likely_unit(1e4 * std::pow(1e3, -1.5), 1e4, "N", "mm", true);
  ASSERT_TRUE(length);
  EXPECT_EQ(length->key, "units.position");
  EXPECT_EQ(length->unit, "um");
  EXPECT_FALSE(likely_unit(2e4, 1e4, "N", "mm", true) &&
               likely_unit(2e4, 1e4, "N", "mm", true)->unit == "N");
}

}  // namespace
}  // namespace palpate::recordings
