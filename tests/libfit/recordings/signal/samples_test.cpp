// From signals to samples, against closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libfit/recordings/contact_point/contact_point.hpp"
#include "tests/libfit/recordings/signal/presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_signal;

TEST(signal, samples_of_a_press_are_the_force_at_the_depth) {
  const Conditioned r = condition(axial_press(400, 200), {}, Vec3(0, 0, -1), "a.csv");
  ASSERT_EQ(r.deflection_m.rows(), 40);
  for (Eigen::Index i = 0; i < 40; ++i)
    EXPECT_NEAR(r.force_N(i, 0),
                3e4 * std::pow(r.deflection_m(i, 0) + r.contact.travel_m - 1e-3, 1.5),
                0.01 * r.force_N(39, 0))
        << i;
  EXPECT_NEAR(r.speed_m_s, 2e-3, 1e-5);
  EXPECT_EQ(r.grade, Grade::good);
}

TEST(signal, a_robots_row_per_depth_is_taken_from_its_own_contact_point) {
  importers::RawRecording raw;
  raw.name = "contact1";
  raw.contact_m = Vec3(0.1, 0.2, 0.3);
  raw.normal = Vec3(0, 0, -1);
  raw.position_m.resize(8, 3);
  raw.force_N.resize(8, 3);
  for (int i = 0; i < 8; ++i) raw.line.push_back(static_cast<std::size_t>(i) + 2);
  for (const double pull_N : {0.0, 0.2}) {  // of a sensor: nothing pulls the tool at its contact
    for (int i = 0; i < 8; ++i) {
      raw.position_m.row(i) << 0.1, 0.2, 0.3 - 5e-4 * i;
      raw.force_N.row(i) << 0.1 * i, 0, pull_N - 0.5 * i;
    }
    const Conditioned r = condition(raw, {}, std::nullopt, "robot.csv");
    EXPECT_EQ(r.contact.estimator, "given");
    EXPECT_EQ(r.reasons.at(0).find("a pull of 0.2 N") != std::string::npos, pull_N > 0);
    ASSERT_EQ(r.deflection_m.rows(), 7);
    EXPECT_LT((r.deflection_m.row(6).transpose() - Vec3(0, 0, -3.5e-3)).norm(), 1e-12);
    EXPECT_LT((r.force_N.row(6).transpose() - Vec3(0.7, 0, -3.5)).norm(), 1e-12);
  }
}

// Down 2 mm past contact, 5 mm sideways, up: the lateral force sticks for 1 mm, then slides.
TEST(signal, a_drag_keeps_press_stick_and_slide_in_order_and_ends_before_the_way_back) {
  importers::RawRecording raw;
  std::vector<Vec3> way, force;
  std::mt19937 random(kPressSeed);
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
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "drag.csv");
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
  std::mt19937 random(kPressSeed);
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
    SignalSettings settings;
    settings.contact =
        contact_estimators()[pick(static_cast<unsigned>(contact_estimators().size()))].name;
    settings.kind = is_axial ? ExperimentKind::press : static_cast<ExperimentKind>(pick(3));
    settings.tip = static_cast<Tip>(pick(3));
    settings.drift = static_cast<Drift>(pick(3));
    settings.use = static_cast<Use>(pick(2));
    settings.smooth_s = has_time && pick(3) == 0 ? 2 : 0;
    settings.rows = 3 + static_cast<int>(pick(60));
    const auto inward = is_axial || pick(2) == 0 ? std::optional(Vec3(0, 0, -1)) : std::nullopt;
    try {
      const Conditioned r = condition(raw, settings, inward, "nonsense.csv");
      ++imported;
      ASSERT_TRUE(r.deflection_m.allFinite() && r.force_N.allFinite() && r.error_N.allFinite())
          << "trial " << trial << " seed " << kPressSeed;
      ASSERT_TRUE(std::isfinite(r.contact.travel_m) && r.contact.deviation_m >= 0)
          << "trial " << trial << " seed " << kPressSeed << " " << settings.contact;
    } catch (const Error& error) {
      ASSERT_FALSE(error.remedy().empty());
    }
  }
  EXPECT_GT(imported, 100);
}

}  // namespace
}  // namespace palpate::recordings
