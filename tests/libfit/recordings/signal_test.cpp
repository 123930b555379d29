// From signals to samples, against closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr unsigned kSeed = 7;

importers::RawRecording axial_press(int rows, double rate_hz) {
  importers::RawRecording raw;
  for (int i = 0; i < rows; ++i) {
    const double t = i / rate_hz, travel = 2e-3 * t, depth = std::max(0.0, travel - 1e-3);
    raw.time_s.push_back(t);
    raw.travel_m.push_back(travel);
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
    raw.push_N.push_back(0.05 + 3e4 * std::pow(depth, 1.5) + 1e-4 * std::sin(40.0 * i));
  }
  return raw;
}

TEST(signal, samples_of_a_press_are_the_force_at_the_depth) {
  const Conditioned r = condition(axial_press(400, 200), {}, Vec3(0, 0, -1), "a.csv", false);
  ASSERT_EQ(r.deflection_m.rows(), 40);
  for (Eigen::Index i = 0; i < 40; ++i)
    EXPECT_NEAR(r.force_N(i, 0),
                3e4 * std::pow(r.deflection_m(i, 0) + r.contact.travel_m - 1e-3, 1.5),
                0.01 * r.force_N(39, 0))
        << i;
  EXPECT_NEAR(r.speed_m_s, 2e-3, 1e-5);
  EXPECT_EQ(r.grade, Grade::good);
}

// 20,000 readings, 1,000 of them in contact: few of equally spaced ones would show the press.
TEST(signal, a_trace_shows_the_whole_and_the_press) {
  auto raw = axial_press(20000, 200);
  for (double& travel : raw.travel_m) travel -= 19e-2;
  for (int i = 0; i < 20000; ++i) {
    const double depth = std::max(0.0, raw.travel_m[static_cast<std::size_t>(i)]);
    raw.push_N[static_cast<std::size_t>(i)] =
        0.05 + 3e2 * std::pow(depth, 1.5) + 1e-4 * std::sin(40.0 * i);
  }
  raw.push_N[700] = 0.5;  // a spike, that samples leave out
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a.csv", false);
  const SignalTrace& t = r.trace;
  ASSERT_LE(t.readings(), 202u);
  for (const std::size_t n : {t.time_s.size(), t.travel_m.size(), t.phase.size(), t.is_used.size()})
    EXPECT_EQ(n, t.readings());
  EXPECT_EQ(t.time_s.front(), 0);
  EXPECT_TRUE(std::is_sorted(t.time_s.begin(), t.time_s.end()));
  EXPECT_EQ(*std::max_element(t.push_N.begin(), t.push_N.end()), 0.5f) << "as recorded";
  EXPECT_EQ(*std::max_element(t.travel_m.begin(), t.travel_m.end()),
            static_cast<float>(raw.travel_m.back()));
  const auto pressed =
      std::count_if(t.travel_m.begin(), t.travel_m.end(), [](float travel) { return travel > 0; });
  EXPECT_GT(pressed, 45);
  EXPECT_NEAR(t.bias_N, 0.05, 1e-4);
  EXPECT_NEAR(t.drift_N_m, 0, 1e-9);
}

TEST(signal, a_trace_says_the_line_that_was_taken_off) {
  auto raw = axial_press(400, 200);
  for (std::size_t i = 0; i < raw.push_N.size(); ++i) raw.push_N[i] += 20 * raw.travel_m[i];
  SignalSettings settings;
  settings.drift = Drift::line;
  settings.known_contact = KnownContact{1e-3, 0};  // a slope alone looks like contact
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "a.csv", false);
  EXPECT_NEAR(r.trace.drift_N_m, 20, 0.5);
  const SignalTrace& t = r.trace;
  for (std::size_t i = 0; i < t.readings(); ++i)
    EXPECT_NEAR(t.push_N[i] - t.bias_N - t.drift_N_m * t.travel_m[i],
                3e4 * std::pow(std::max(0.0, t.travel_m[i] - 1e-3), 1.5), 2e-3);
}

TEST(signal, a_refused_recording_keeps_its_trace) {
  auto raw = axial_press(400, 200);
  for (double& push : raw.push_N) push = 0.05 - push;
  SignalTrace trace;
  EXPECT_THROW(condition(raw, {}, Vec3(0, 0, -1), "a.csv", false, &trace), Error);
  EXPECT_GT(trace.readings(), 190u);
}

TEST(signal, clocks_of_different_rate_and_a_late_force_give_the_same_samples) {
  const auto plain = axial_press(400, 200);
  auto other = plain;
  const double late_s = 0.03;
  other.force_time_s = other.time_s;
  for (double& t : other.force_time_s) t += late_s;
  other.time_s.clear(), other.travel_m.clear(), other.line.clear();
  for (int i = 0; i < 90; ++i) {
    const double t = i / 44.0;
    other.time_s.push_back(t);
    other.travel_m.push_back(2e-3 * t);
    other.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  SignalSettings settings;
  settings.force_delay_s = late_s;
  const Conditioned a = condition(plain, {}, Vec3(0, 0, -1), "a.csv", false),
                    b = condition(other, settings, Vec3(0, 0, -1), "a.csv", false);
  EXPECT_NEAR(a.contact.travel_m, b.contact.travel_m, 2e-6);
  EXPECT_LT((a.force_N - b.force_N).cwiseAbs().maxCoeff(), 0.002 * a.force_N.maxCoeff());
}

TEST(signal, the_filter_has_no_delay_and_keeps_ramps) {
  Signal signal;
  signal.position_m = signal.force_N = Points::Zero(400, 3);
  for (int i = 0; i < 400; ++i) {
    signal.time_s.push_back(0.005 * i);
    signal.force_N(i, 0) = 3 + 2 * 0.005 * i;
    signal.force_N(i, 1) = std::sin(2 * 3.14159265358979 * 1.0 * 0.005 * i);
    signal.force_N(i, 2) = i % 2 ? 1 : -1;
  }
  const Points before = signal.force_N;
  smooth(signal, 0.02);
  EXPECT_LT((signal.force_N.col(0) - before.col(0)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(signal.force_N.col(2).segment(20, 360).cwiseAbs().maxCoeff(), 1e-3);
  // A delay of one row would leave 0.03 of the sine; its attenuation at 1 Hz is exp(-(2 pi 0.02)^2
  // / 2).
  EXPECT_LT((signal.force_N.col(1) -
             std::exp(-0.5 * std::pow(2 * 3.14159265358979 * 0.02, 2)) * before.col(1))
                .segment(20, 360)
                .cwiseAbs()
                .maxCoeff(),
            1e-3);
}

TEST(signal, compliance_of_the_rig_is_taken_off) {
  auto raw = axial_press(400, 200);
  for (std::size_t i = 0; i < raw.travel_m.size(); ++i)
    raw.travel_m[i] += 1e-4 * (raw.push_N[i] - raw.push_N[0]);
  SignalSettings settings;
  settings.compliance_m_N = 1e-4;
  const Conditioned a = condition(axial_press(400, 200), {}, Vec3(0, 0, -1), "a", false),
                    b = condition(raw, settings, Vec3(0, 0, -1), "b", false);
  EXPECT_LT((a.deflection_m - b.deflection_m).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(signal, drift_along_the_way_is_taken_off_on_request) {
  auto raw = axial_press(400, 200);
  for (std::size_t i = 0; i < raw.push_N.size(); ++i) raw.push_N[i] += 20 * raw.travel_m[i];
  SignalSettings settings;
  settings.drift = Drift::line;
  settings.contact = "hertz";
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "a", false);
  EXPECT_NEAR(r.force_N(39, 0),
              3e4 * std::pow(r.deflection_m(39, 0) + r.contact.travel_m - 1e-3, 1.5),
              0.03 * r.force_N(39, 0));
}

TEST(signal, saturated_rows_are_marked_and_never_good) {
  auto raw = axial_press(400, 200);
  const double limit_N = 0.6 * raw.push_N.back();
  for (double& push : raw.push_N) push = std::min(push, limit_N);
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a", false);
  int rejected = 0;
  for (Eigen::Index i = 0; i < r.force_N.rows(); ++i) {
    rejected += r.status[static_cast<std::size_t>(i)] == RowStatus::rejected;
    if (r.force_N(i, 0) > 0.99 * (limit_N - 0.05)) {
      EXPECT_EQ(r.status[static_cast<std::size_t>(i)], RowStatus::rejected) << i;
    }
  }
  EXPECT_GT(rejected, 5);
  EXPECT_EQ(r.grade, Grade::fair);
}

// Once a limiter was believed only at the largest reading: noise just before it hid one in 10 000.
TEST(signal, a_limiter_is_seen_though_a_reading_before_it_was_higher) {
  auto raw = axial_press(400, 200);
  const double limit_N = 0.6 * raw.push_N.back();
  std::size_t first = 0;
  while (raw.push_N[first] < limit_N) ++first;
  for (double& push : raw.push_N) push = std::min(push, limit_N);
  raw.push_N[first] = raw.push_N[first - 1] = 1.1 * limit_N;
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a", false);
  EXPECT_EQ(r.status.back(), RowStatus::rejected);
  EXPECT_EQ(r.status.front(), RowStatus::good);
}

TEST(signal, approach_hold_slide_and_retract_are_told_apart) {
  Signal signal;
  signal.inward = Vec3(0, 0, -1);
  std::vector<Vec3> way;
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-5 * i);
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-5 * i, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-3, 0, -1e-3 + 1e-5 * i);
  signal.position_m.resize(400, 3);
  signal.force_N = Points::Zero(400, 3);
  for (int i = 0; i < 400; ++i) signal.position_m.row(i) = way[static_cast<std::size_t>(i)];
  for (const double jitter_m : {0., 1e-7, 1e-6, 5e-6})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> draw(0, 1);
      for (std::size_t i = 0; i < way.size(); ++i)
        signal.position_m.row(static_cast<Eigen::Index>(i)) << way[i].x() + jitter_m * draw(random),
            way[i].y() + jitter_m * draw(random), way[i].z();
      const auto phases = find_phases(signal);
      EXPECT_EQ(phases[50], Phase::approach) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[150], Phase::hold) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[250], Phase::slide) << jitter_m << " m, seed " << seed;
      EXPECT_EQ(phases[350], Phase::retract) << jitter_m << " m, seed " << seed;
    }
}

TEST(signal, a_robots_row_per_depth_is_taken_from_its_own_contact_point) {
  importers::RawRecording raw;
  raw.name = "contact1";
  raw.contact_m = Vec3(0.1, 0.2, 0.3);
  raw.normal = Vec3(0, 0, -1);
  raw.position_m.resize(8, 3);
  raw.force_N.resize(8, 3);
  for (int i = 0; i < 8; ++i) {
    raw.position_m.row(i) << 0.1, 0.2, 0.3 - 5e-4 * i;
    raw.force_N.row(i) << 0.1 * i, 0, -0.5 * i;
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  const Conditioned r = condition(raw, {}, std::nullopt, "robot.csv", false);
  EXPECT_EQ(r.contact.estimator, "given");
  ASSERT_EQ(r.deflection_m.rows(), 7);
  EXPECT_LT((r.deflection_m.row(6).transpose() - Vec3(0, 0, -3.5e-3)).norm(), 1e-12);
  EXPECT_LT((r.force_N.row(6).transpose() - Vec3(0.7, 0, -3.5)).norm(), 1e-12);
}

// A ball of 5 mm pressed 3 mm into 10 kPa after 1 mm of air and back, at a constant speed, turning
// at a reading or between two; exactly elastic but for the noise.
importers::RawRecording elastic_press(int readings, double turn, double noise_N, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_N);
  importers::RawRecording raw;
  for (int i = 0; i < readings; ++i) {
    const double way = (i + turn) / (readings - 1), share = way < 0.5 ? 2 * way : 2 - 2 * way;
    raw.time_s.push_back(0.02 * i);
    raw.travel_m.push_back(4e-3 * share);
    raw.push_N.push_back(4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) *
                             std::pow(std::max(0.0, 4e-3 * share - 1e-3), 1.5) +
                         noise(random));
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  return raw;
}

// Once the way out began a reading or more after the deepest one: +24 % at 25 readings.
TEST(signal, an_elastic_press_has_no_hysteresis_however_it_is_sampled) {
  for (const int readings : {25, 26, 50, 51, 100, 250})
    for (const double turn : {0.0, 0.3, 0.5, 0.8}) {
      SignalSettings settings;
      settings.radius_m = 5e-3;
      const Conditioned r =
          condition(elastic_press(readings, turn, 1e-4, kSeed), settings, {}, "a.csv", false);
      EXPECT_NEAR(r.hysteresis, 0, 0.01)
          << readings << " readings, turn " << turn << ", seed " << kSeed;
    }
}

// Noise on a flat top once put the largest push rows before the turn, and there was no way back.
TEST(signal, a_noisy_press_of_many_readings_has_its_way_back) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Conditioned r = condition(elastic_press(4000, 0, 5e-3, seed), {}, {}, "a.csv", false);
    EXPECT_NEAR(r.hysteresis, 0, 0.02) << "seed " << seed;
  }
}

// Half of the work lost, in closed form: the way out has half the force of the way in.
TEST(signal, the_work_that_is_lost_is_the_hysteresis) {
  for (const int readings : {25, 100, 250}) {
    auto raw = elastic_press(readings, 0, 0, kSeed);
    for (std::size_t i = raw.push_N.size() / 2 + 1; i < raw.push_N.size(); ++i) raw.push_N[i] /= 2;
    const Conditioned r = condition(raw, {}, {}, "a.csv", false);
    // Half, but for the step at the turn: a trapezium from the whole to half of the force.
    EXPECT_NEAR(r.hysteresis, 0.5, readings < 50 ? 0.07 : 0.02) << readings;
  }
}

// Once the work of a file that ends in contact, on the way out or in a hold, was "not given back".
TEST(signal, a_recording_that_ends_in_contact_says_nothing_of_the_work_given_back) {
  const auto whole = elastic_press(400, 0, 1e-4, kSeed);  // 400 readings, deepest in the middle
  const auto hysteresis = [&](int way_out, int hold, double jitter_m) {
    auto raw = whole;
    const std::size_t kept = 200 + way_out;
    raw.travel_m.resize(kept), raw.push_N.resize(kept);
    std::mt19937 random(kSeed);
    std::normal_distribution<double> noise(0, 1);
    for (int i = 0; i < hold; ++i) {
      raw.travel_m.push_back(raw.travel_m[kept - 1] + jitter_m * noise(random));
      raw.push_N.push_back(raw.push_N[kept - 1] + 1e-4 * noise(random));
    }
    raw.time_s.clear(), raw.line.clear();
    for (std::size_t i = 0; i < raw.travel_m.size(); ++i)
      raw.time_s.push_back(0.02 * static_cast<double>(i)), raw.line.push_back(i + 2);
    return condition(raw, {}, {}, "a.csv", false).hysteresis;
  };
  for (const int way_out : {0, 3, 10, 50, 100})
    EXPECT_TRUE(std::isnan(hysteresis(way_out, 0, 0))) << way_out;
  for (const double jitter_m : {0.0, 1e-6, 2e-5, 5e-5})
    EXPECT_TRUE(std::isnan(hysteresis(0, 200, jitter_m))) << jitter_m;
  for (const int way_out : {140, 150, 200})  // less than a percent of the work is stored, or none
    EXPECT_NEAR(hysteresis(way_out, 0, 0), 0, 0.015) << way_out;
}

// Once 0.1 mm of noise beside 10 um of way a reading was a slide: "the tip goes in over 4 rows".
TEST(signal, an_encoders_noise_beside_the_way_ends_no_press) {
  const Vec3 inward(0, 0, -1);
  for (const int readings : {50, 250, 1000})
    for (const double jitter_m : {1e-7, 1e-6, 1e-5, 1e-4, 3e-4})
      for (unsigned seed = 1; seed <= 5; ++seed) {
        const auto axis = elastic_press(readings, 0.3, 1e-3, seed);
        importers::RawRecording robot = axis;
        std::mt19937 random(seed);
        std::normal_distribution<double> draw;
        robot.travel_m.clear(), robot.push_N.clear();
        robot.position_m.resize(readings, 3), robot.force_N.resize(readings, 3);
        const double lean = std::tan(2.0 * seed * 3.14159265 / 180);  // to 10 degrees
        for (int i = 0; i < readings; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const double travel_m = axis.travel_m[at], push_N = axis.push_N[at];
          robot.position_m.row(i) << lean * travel_m + jitter_m * draw(random),
              jitter_m * draw(random), -travel_m;
          robot.force_N.row(i) << 0.05 * push_N, 0, -push_N;
        }
        const Conditioned one = condition(axis, {}, {}, "axis.csv", false),
                          three = condition(robot, {}, inward, "robot.csv", false);
        const auto where = testing::Message()
                           << readings << " readings, " << jitter_m << " m, seed " << seed;
        EXPECT_NEAR(three.contact.travel_m, one.contact.travel_m, 1e-6) << where;
        ASSERT_EQ(three.deflection_m.rows(), one.deflection_m.rows()) << where;
        // A reading at the turn may count in one alone: rows then have other readings, with a noise
        // of 1 mN each, and move along the curve.
        const auto hertz_N = [](double depth_m) {
          return 4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) * std::pow(depth_m, 1.5);
        };
        for (Eigen::Index i = 0; i < one.deflection_m.rows(); ++i) {
          const double depth_m = three.deflection_m.row(i) * inward,
                       push_N = three.force_N.row(i) * inward,
                       of_axis_N = one.force_N(i, 0) - hertz_N(one.deflection_m(i, 0));
          EXPECT_NEAR(push_N - hertz_N(depth_m), of_axis_N, 3e-3) << where << ", row " << i;
        }
      }
}

std::string refusal_of(const importers::RawRecording& raw, const std::optional<Vec3>& inward) {
  try {
    condition(raw, {}, inward, "a.csv", false);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Once a light that waved while a pyramid was pressed in 0.2 um was "the tool breaks in", and 16
// presses of a force map ended at a sixth of their depth.
TEST(signal, push_that_waves_while_the_tip_goes_in_is_no_break) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto raw = elastic_press(1000, 0.3, 1e-4, seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> draw;
    double wave = 0, before = 0;
    for (double& push_N : raw.push_N) {
      wave = 0.7 * wave + draw(random);
      if (push_N > 0.01) push_N += 0.008 * (wave + before) / 2;
      before = wave;
    }
    const Conditioned r = condition(raw, {}, {}, "a.csv", false);
    EXPECT_FALSE(r.breaks) << "seed " << seed;
    EXPECT_GT(r.deflection_m.col(0).maxCoeff(), 2.5e-3) << "seed " << seed;
  }
}

TEST(signal, a_position_that_scatters_asks_for_a_filter) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    auto raw = elastic_press(1000, 0.3, 1e-3, seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> scatter_m(0, 1e-4);
    for (double& travel_m : raw.travel_m) travel_m += scatter_m(random);
    EXPECT_NE(refusal_of(raw, {}).find("the position scatters by 0."), std::string::npos)
        << "seed " << seed << ": " << refusal_of(raw, {});
    EXPECT_NE(refusal_of(raw, {}).find("smooth = "), std::string::npos);
    SignalSettings settings;
    settings.smooth_s = 0.2, settings.radius_m = 5e-3;
    const Conditioned r = condition(raw, settings, {}, "a.csv", false);
    const Eigen::Index last = r.force_N.rows() - 1;
    const double depth_m = r.deflection_m(last, 0);
    EXPECT_NEAR(r.force_N(last, 0), 4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) * std::pow(depth_m, 1.5),
                0.1 * r.force_N(last, 0))
        << "seed " << seed;
  }
}

// Once the way back was taken for the way in: 17 to 27 kPa for 10, "fair".
TEST(signal, a_press_with_both_signs_reversed_says_so) {
  for (const int readings : {25, 100, 1000})
    for (const double free_N : {0.0, 0.02, -0.05}) {
      auto raw = elastic_press(readings, 0.3, 1e-3, kSeed);
      for (double& push_N : raw.push_N) push_N += free_N;
      EXPECT_EQ(refusal_of(raw, {}), "") << readings;
      for (double& travel : raw.travel_m) travel = -travel;
      for (double& push : raw.push_N) push = -push;
      EXPECT_NE(refusal_of(raw, {}).find("depth and force both have the reversed sign"),
                std::string::npos)
          << readings << ", " << free_N << ": " << refusal_of(raw, {});
    }
}

TEST(signal, a_compression_without_free_travel_and_with_both_signs_reversed_says_so) {
  for (const double exponent : {1.0, 1.5, 2.0}) {
    importers::RawRecording raw;
    std::mt19937 random(kSeed);
    std::normal_distribution<double> noise(0, 5e-3);
    for (int i = 0; i <= 400; ++i) {
      const double share = i <= 200 ? i / 200.0 : 2 - i / 200.0;
      raw.travel_m.push_back(-5e-3 * share);
      raw.push_N.push_back(-10 * std::pow(share, exponent) + noise(random));
      raw.line.push_back(static_cast<std::size_t>(i) + 1);
    }
    EXPECT_NE(refusal_of(raw, {}).find("both have the reversed sign"), std::string::npos)
        << exponent << ": " << refusal_of(raw, {});
  }
}

TEST(signal, a_normal_that_points_outward_is_told_by_both_signs) {
  const auto axial = elastic_press(200, 0, 1e-3, kSeed);
  importers::RawRecording raw;
  raw.time_s = axial.time_s, raw.line = axial.line;
  raw.position_m = raw.force_N = Points::Zero(200, 3);
  for (Eigen::Index i = 0; i < 200; ++i) {
    raw.position_m(i, 2) = -axial.travel_m[static_cast<std::size_t>(i)];
    raw.force_N(i, 2) = -axial.push_N[static_cast<std::size_t>(i)];
  }
  EXPECT_EQ(refusal_of(raw, Vec3(0, 0, -1)), "");
  EXPECT_NE(refusal_of(raw, Vec3(0, 0, 1)).find("the normal points out of the body"),
            std::string::npos)
      << refusal_of(raw, Vec3(0, 0, 1));
}

// Microscopes may begin with the way back from a press: force and signs are right.
TEST(signal, a_recording_that_begins_with_a_way_back_is_read) {
  for (const double free_N : {0.0, -0.02, -1.0}) {
    auto raw = elastic_press(400, 0, 1e-3, kSeed);
    std::rotate(raw.travel_m.begin(), raw.travel_m.begin() + 200, raw.travel_m.end());
    std::rotate(raw.push_N.begin(), raw.push_N.begin() + 200, raw.push_N.end());
    for (double& push_N : raw.push_N) push_N += free_N;
    EXPECT_EQ(refusal_of(raw, {}), "") << free_N;
  }
}

// Down 2 mm past contact, 5 mm sideways, up: the lateral force sticks for 1 mm, then slides.
TEST(signal, a_drag_keeps_press_stick_and_slide_in_order_and_ends_before_the_way_back) {
  importers::RawRecording raw;
  std::vector<Vec3> way, force;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> noise(0, 1e-3);
  for (int i = 0; i < 300; ++i) way.emplace_back(0, 0, 1e-3 - 1e-5 * i);
  for (int i = 1; i <= 500; ++i) way.emplace_back(1e-5 * i, 0, -2e-3);
  for (int i = 1; i <= 300; ++i) way.emplace_back(5e-3, 0, -2e-3 + 1e-5 * i);
  raw.position_m.resize(1100, 3);
  raw.force_N.resize(1100, 3);
  for (int i = 0; i < 1100; ++i) {
    const Vec3& x = way[static_cast<std::size_t>(i)];
    const double push = 3e4 * std::pow(std::max(0.0, -x.z()), 1.5);
    raw.time_s.push_back(0.01 * i);
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
    raw.position_m.row(i) = x;
    raw.force_N.row(i) << std::min(1000 * x.x(), 0.4 * push) + noise(random), noise(random),
        -push + noise(random);
  }
  SignalSettings settings;
  settings.kind = ExperimentKind::drag;
  settings.rows = 60;
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "drag.csv", false);
  const Eigen::Index last = r.deflection_m.rows() - 1;
  EXPECT_NEAR(r.deflection_m(last, 0), 5e-3, 2e-4);
  EXPECT_NEAR(-r.deflection_m(last, 2), 2e-3, 1e-4);
  EXPECT_NEAR(r.force_N(last, 0), 0.4 * 3e4 * std::pow(2e-3, 1.5), 0.02);
  for (Eigen::Index i = 1; i <= last; ++i)  // never back
    EXPECT_GT(r.deflection_m(i, 0) - r.deflection_m(i, 2),
              r.deflection_m(i - 1, 0) - r.deflection_m(i - 1, 2) - 1e-6)
        << i;
}

// Nonsense of every kind: finite samples or an Error, whatever the settings.
TEST(signal, any_signal_gives_finite_samples_or_an_error) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto pick = [&](unsigned n) { return random() % n; };
  int imported = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    importers::RawRecording raw;
    const int rows = 1 + static_cast<int>(pick(120));
    const bool is_axial = pick(2) == 0, has_time = pick(3) != 0;
    const double step = std::pow(10, 6 * unit(random) - 6),
                 scale_N = std::pow(10, 6 * unit(random));
    double x = 0;
    raw.position_m.resize(is_axial ? 0 : rows, 3);
    raw.force_N.resize(is_axial ? 0 : rows, 3);
    for (int i = 0; i < rows; ++i) {
      x += pick(4) == 0 ? 0 : step * (unit(random) + static_cast<double>(pick(3)) - 0.5);
      const double push_N =
          pick(5) == 0 ? 1e15 * unit(random) : scale_N * (x / step + unit(random));
      if (has_time) raw.time_s.push_back(i);
      if (is_axial) {
        raw.travel_m.push_back(x);
        raw.push_N.push_back(push_N);
      } else {
        raw.position_m.row(i) << step * unit(random), 0, -x;
        raw.force_N.row(i) << 0, 0, -push_N;
      }
      raw.line.push_back(static_cast<std::size_t>(i) + 1);
    }
    if (pick(4) == 0 && is_axial)
      raw.retract_begins = static_cast<Eigen::Index>(pick(static_cast<unsigned>(rows)));
    SignalSettings settings;
    settings.contact =
        contact_estimators()[pick(static_cast<unsigned>(contact_estimators().size()))].name;
    settings.kind = is_axial ? ExperimentKind::press : static_cast<ExperimentKind>(pick(3));
    settings.tip = static_cast<Tip>(pick(3));
    settings.drift = static_cast<Drift>(pick(3));
    settings.use = static_cast<Use>(pick(3));
    settings.smooth_s = has_time && pick(3) == 0 ? 2 : 0;
    settings.rows = 3 + static_cast<int>(pick(60));
    const auto inward = is_axial || pick(2) == 0 ? std::optional(Vec3(0, 0, -1)) : std::nullopt;
    try {
      const Conditioned r = condition(raw, settings, inward, "nonsense.csv", false);
      ++imported;
      ASSERT_TRUE(r.deflection_m.allFinite() && r.force_N.allFinite() && r.error_N.allFinite())
          << "trial " << trial << " seed " << kSeed;
      ASSERT_TRUE(std::isfinite(r.contact.travel_m) && r.contact.deviation_m >= 0)
          << "trial " << trial << " seed " << kSeed << " " << settings.contact;
    } catch (const Error& error) {
      ASSERT_FALSE(error.remedy().empty());
    }
  }
  EXPECT_GT(imported, 100);
}

}  // namespace
}  // namespace palpate::recordings
