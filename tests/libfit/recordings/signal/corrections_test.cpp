// Clocks, noise, the rig and the sensor: what is taken off a signal, and what is marked in it.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libfit/recordings/signal/signal.hpp"
#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

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
  const Conditioned a = condition(plain, {}, Vec3(0, 0, -1), "a.csv"),
                    b = condition(other, settings, Vec3(0, 0, -1), "a.csv");
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
  const Conditioned a = condition(axial_press(400, 200), {}, Vec3(0, 0, -1), "a"),
                    b = condition(raw, settings, Vec3(0, 0, -1), "b");
  EXPECT_LT((a.deflection_m - b.deflection_m).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(signal, drift_along_the_way_is_taken_off_on_request) {
  auto raw = axial_press(400, 200);
  for (std::size_t i = 0; i < raw.push_N.size(); ++i) raw.push_N[i] += 20 * raw.travel_m[i];
  SignalSettings settings;
  settings.drift = Drift::line;
  settings.contact = "hertz";
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "a");
  EXPECT_NEAR(r.force_N(39, 0),
              3e4 * std::pow(r.deflection_m(39, 0) + r.contact.travel_m - 1e-3, 1.5),
              0.03 * r.force_N(39, 0));
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
    const Conditioned r = condition(raw, settings, {}, "a.csv");
    const Eigen::Index last = r.force_N.rows() - 1;
    const double depth_m = r.deflection_m(last, 0);
    EXPECT_NEAR(r.force_N(last, 0), 4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) * std::pow(depth_m, 1.5),
                0.1 * r.force_N(last, 0))
        << "seed " << seed;
  }
}

TEST(signal, saturated_rows_are_marked_and_never_good) {
  auto raw = axial_press(400, 200);
  const double limit_N = 0.6 * raw.push_N.back();
  for (double& push : raw.push_N) push = std::min(push, limit_N);
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a");
  int rejected = 0;
  for (Eigen::Index i = 0; i < r.force_N.rows(); ++i) {
    rejected += r.status[static_cast<std::size_t>(i)] == RowStatus::rejected;
    if (r.force_N(i, 0) > 0.99 * (limit_N - 0.05)) {
      EXPECT_EQ(r.status[static_cast<std::size_t>(i)], RowStatus::rejected) << i;
    }
  }
  EXPECT_GT(rejected, 5);
  EXPECT_EQ(r.grade, Grade::fair);
  SignalSettings settings;
  settings.force_limit_N = limit_N;  // readings above it are no more than at it
  const Conditioned known = condition(axial_press(400, 200), settings, Vec3(0, 0, -1), "a");
  EXPECT_EQ(known.status.front(), RowStatus::good);
  EXPECT_EQ(known.status.back(), RowStatus::rejected);
}

// Once a limiter was believed only at the largest reading: noise just before it hid one in 10 000.
TEST(signal, a_limiter_is_seen_though_a_reading_before_it_was_higher) {
  auto raw = axial_press(400, 200);
  const double limit_N = 0.6 * raw.push_N.back();
  std::size_t first = 0;
  while (raw.push_N[first] < limit_N) ++first;
  for (double& push : raw.push_N) push = std::min(push, limit_N);
  raw.push_N[first] = raw.push_N[first - 1] = 1.1 * limit_N;
  const Conditioned r = condition(raw, {}, Vec3(0, 0, -1), "a");
  EXPECT_EQ(r.status.back(), RowStatus::rejected);
  EXPECT_EQ(r.status.front(), RowStatus::good);
}

}  // namespace
}  // namespace palpate::recordings
