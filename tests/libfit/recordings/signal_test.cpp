// From signals to samples, against closed forms.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "libfit/recordings/assemble.hpp"
#include "libfit/recordings/condition.hpp"
#include "libfit/recordings/contact.hpp"
#include "libfit/recordings/phases.hpp"
#include "libfit/recordings/plausible.hpp"

namespace palpate::recordings {
namespace {

constexpr unsigned kSeed = 7;

// One-axis press of F = a d^p, contact at 1 mm of travel, to 3 mm.
PressCurve power_curve(double exponent, double noise_N, unsigned seed, double stiffens_1_m = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_N);
  PressCurve curve;
  const Eigen::Index n = 300;
  curve.travel_m = Eigen::VectorXd::LinSpaced(n, 0, 3e-3);
  curve.push_N.resize(n), curve.count = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double depth = std::max(0.0, curve.travel_m[i] - 1e-3);
    curve.push_N[i] = 0.01 + std::pow(depth / 2e-3, exponent) * (1 + stiffens_1_m * depth) +
                      (noise_N > 0 ? noise(random) : 0);
  }
  curve.noise_N = noise_N;
  return curve;
}

TEST(contact, power_laws_of_their_own_tip_are_found_exactly) {
  for (const Tip tip : {Tip::sphere, Tip::flat, Tip::cone}) {
    SignalSettings settings;
    settings.tip = tip;
    const auto found = contact_estimator_named("hertz")->estimate(
        power_curve(exponent_of(tip), 0, kSeed), settings);
    EXPECT_NEAR(found.travel_m, 1e-3, 2e-7) << static_cast<int>(tip);
    EXPECT_NEAR(found.bias_N, 0.01, 1e-5);
    EXPECT_NEAR(found.amplitude, std::pow(2e-3, -exponent_of(tip)),
                1e-3 * std::pow(2e-3, -exponent_of(tip)));
  }
}

TEST(contact, the_stated_deviation_is_the_scatter_over_noisy_repeats) {
  double squares = 0, stated = 0;
  const int repeats = 60;
  for (unsigned k = 0; k < repeats; ++k) {
    SignalSettings settings;
    settings.contact_range = 1;
    const auto found =
        contact_estimator_named("hertz")->estimate(power_curve(1.5, 0.02, kSeed + k), settings);
    squares += std::pow(found.travel_m - 1e-3, 2), stated += found.deviation_m / repeats;
  }
  const double scatter = std::sqrt(squares / repeats);
  EXPECT_LT(scatter, 40e-6);
  EXPECT_GT(stated, scatter / 2) << "seed " << kSeed;
  EXPECT_LT(stated, scatter * 2) << "seed " << kSeed;
}

TEST(contact, every_estimator_finds_a_clean_contact_within_its_deviation_or_a_tenth_of_the_depth) {
  for (const ContactEstimator& row : contact_estimators()) {
    const auto found = row.estimate(power_curve(1.5, 1e-3, kSeed), {});
    EXPECT_NEAR(found.travel_m, 1e-3, std::max(4 * found.deviation_m, 0.2e-3)) << row.name;
    EXPECT_FALSE(found.begins_in_contact) << row.name;
  }
}

TEST(contact, a_body_that_stiffens_does_not_push_the_contact_in) {
  const auto found =
      contact_estimator_named("auto")->estimate(power_curve(1.5, 1e-3, kSeed, 2000), {});
  EXPECT_NEAR(found.travel_m, 1e-3, 0.1e-3);
}

TEST(contact, a_recording_that_begins_in_contact_says_so) {
  PressCurve curve = power_curve(1, 1e-3, kSeed);
  curve.travel_m = curve.travel_m.tail(180).eval(), curve.push_N = curve.push_N.tail(180).eval(),
  curve.count = curve.count.tail(180).eval();
  EXPECT_TRUE(contact_estimator_named("auto")->estimate(curve, {}).begins_in_contact);
}

importers::RawRecording axial_press(int rows, double rate_hz) {
  importers::RawRecording raw;
  for (int i = 0; i < rows; ++i) {
    const double t = i / rate_hz, travel = 2e-3 * t, depth = std::max(0.0, travel - 1e-3);
    raw.time_s.push_back(t), raw.travel_m.push_back(travel),
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
                3e4 * std::pow(r.deflection_m(i, 0) + r.contact_travel_m - 1e-3, 1.5),
                0.01 * r.force_N(39, 0))
        << i;
  EXPECT_NEAR(r.speed_m_s, 2e-3, 1e-5);
  EXPECT_EQ(r.grade, Grade::good);
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
    other.time_s.push_back(t), other.travel_m.push_back(2e-3 * t),
        other.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  SignalSettings settings;
  settings.force_delay_s = late_s;
  const Conditioned a = condition(plain, {}, Vec3(0, 0, -1), "a.csv", false),
                    b = condition(other, settings, Vec3(0, 0, -1), "a.csv", false);
  EXPECT_NEAR(a.contact_travel_m, b.contact_travel_m, 2e-6);
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
  settings.drift = Drift::line, settings.contact = "hertz";
  const Conditioned r = condition(raw, settings, Vec3(0, 0, -1), "a", false);
  EXPECT_NEAR(r.force_N(39, 0),
              3e4 * std::pow(r.deflection_m(39, 0) + r.contact_travel_m - 1e-3, 1.5),
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

TEST(signal, approach_hold_slide_and_retract_are_told_apart) {
  Signal signal;
  signal.inward = Vec3(0, 0, -1);
  std::vector<Vec3> way;
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-5 * i);
  for (int i = 0; i < 100; ++i) way.emplace_back(0, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-5 * i, 0, -1e-3);
  for (int i = 0; i < 100; ++i) way.emplace_back(1e-3, 0, -1e-3 + 1e-5 * i);
  signal.position_m.resize(400, 3), signal.force_N = Points::Zero(400, 3);
  for (int i = 0; i < 400; ++i) signal.position_m.row(i) = way[static_cast<std::size_t>(i)];
  const auto phases = find_phases(signal);
  EXPECT_EQ(phases[50], Phase::approach);
  EXPECT_EQ(phases[150], Phase::hold);
  EXPECT_EQ(phases[250], Phase::slide);
  EXPECT_EQ(phases[350], Phase::retract);
}

TEST(signal, a_robots_row_per_depth_is_taken_from_its_own_contact_point) {
  importers::RawRecording raw;
  raw.name = "contact1";
  raw.contact_m = Vec3(0.1, 0.2, 0.3), raw.normal = Vec3(0, 0, -1);
  raw.position_m.resize(8, 3), raw.force_N.resize(8, 3);
  for (int i = 0; i < 8; ++i) {
    raw.position_m.row(i) << 0.1, 0.2, 0.3 - 5e-4 * i;
    raw.force_N.row(i) << 0.1 * i, 0, -0.5 * i;
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  const Conditioned r = condition(raw, {}, std::nullopt, "robot.csv", false);
  EXPECT_EQ(r.estimator, "given");
  ASSERT_EQ(r.deflection_m.rows(), 7);
  EXPECT_LT((r.deflection_m.row(6).transpose() - Vec3(0, 0, -3.5e-3)).norm(), 1e-12);
  EXPECT_LT((r.force_N.row(6).transpose() - Vec3(0.7, 0, -3.5)).norm(), 1e-12);
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
  raw.position_m.resize(1100, 3), raw.force_N.resize(1100, 3);
  for (int i = 0; i < 1100; ++i) {
    const Vec3& x = way[static_cast<std::size_t>(i)];
    const double push = 3e4 * std::pow(std::max(0.0, -x.z()), 1.5);
    raw.time_s.push_back(0.01 * i), raw.line.push_back(static_cast<std::size_t>(i) + 2);
    raw.position_m.row(i) = x;
    raw.force_N.row(i) << std::min(1000 * x.x(), 0.4 * push) + noise(random), noise(random),
        -push + noise(random);
  }
  SignalSettings settings;
  settings.kind = ExperimentKind::drag, settings.rows = 60;
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
    raw.position_m.resize(is_axial ? 0 : rows, 3), raw.force_N.resize(is_axial ? 0 : rows, 3);
    for (int i = 0; i < rows; ++i) {
      x += pick(4) == 0 ? 0 : step * (unit(random) + static_cast<double>(pick(3)) - 0.5);
      const double push_N =
          pick(5) == 0 ? 1e15 * unit(random) : scale_N * (x / step + unit(random));
      if (has_time) raw.time_s.push_back(i);
      if (is_axial) raw.travel_m.push_back(x), raw.push_N.push_back(push_N);
      else {
        raw.position_m.row(i) << step * unit(random), 0, -x;
        raw.force_N.row(i) << 0, 0, -push_N;
      }
      raw.line.push_back(static_cast<std::size_t>(i) + 1);
    }
    if (pick(4) == 0 && is_axial)
      raw.retract_begins = static_cast<Eigen::Index>(pick(static_cast<unsigned>(rows)));
    SignalSettings settings;
    settings.contact = contact_estimators()[pick(5)].name;
    settings.kind = is_axial ? ExperimentKind::press : static_cast<ExperimentKind>(pick(3));
    settings.tip = static_cast<Tip>(pick(3)), settings.drift = static_cast<Drift>(pick(3));
    settings.uses_retract = pick(4) == 0, settings.smooth_s = has_time && pick(3) == 0 ? 2 : 0;
    settings.rows = 3 + static_cast<int>(pick(60));
    const auto inward = is_axial || pick(2) == 0 ? std::optional(Vec3(0, 0, -1)) : std::nullopt;
    try {
      const Conditioned r = condition(raw, settings, inward, "nonsense.csv", false);
      ++imported;
      ASSERT_TRUE(r.deflection_m.allFinite() && r.force_N.allFinite() && r.error_N.allFinite())
          << "trial " << trial << " seed " << kSeed;
      ASSERT_TRUE(std::isfinite(r.contact_travel_m) && r.contact_deviation_m >= 0)
          << "trial " << trial << " seed " << kSeed << " " << settings.contact;
    } catch (const Error& error) {
      ASSERT_FALSE(error.remedy().empty());
    }
  }
  EXPECT_GT(imported, 100);
}

Surface bumpy_sheet() {
  Surface s;
  const int n = 21;
  s.vertices.resize(n * n, 3), s.triangles.resize(2 * (n - 1) * (n - 1), 3);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = 0.005 * i, y = 0.005 * j;
      s.vertices.row(j * n + i) << x, y, 0.004 * std::sin(60 * x) * std::cos(45 * y) + 0.1 * x * y;
    }
  int t = 0;
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i;
      s.triangles.row(t++) << a, a + 1, a + n + 1;
      s.triangles.row(t++) << a, a + n + 1, a + n;
    }
  return s;
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
  std::mt19937 random(kSeed);
  Points body(80, 3), rig(80, 3);
  const RigidMotion away = some_motion(0.05, 0.001);
  for (Eigen::Index i = 0; i < 80; ++i) {
    body.row(i) = surface.vertices.row(static_cast<Eigen::Index>(random() % 441));
    rig.row(i) = away.rotation.transpose() * (Vec3(body.row(i)) - away.translation_m);
  }
  const Registration found = register_to_surface(rig, surface, {});
  EXPECT_LT(found.rms_m, 1e-6) << "seed " << kSeed;
  EXPECT_LT((found.motion.rotation - away.rotation).cwiseAbs().maxCoeff(), 1e-4)
      << "seed " << kSeed;
}

TEST(registration, landmarks_on_one_line_are_refused) {
  Points line(4, 3);
  for (int i = 0; i < 4; ++i) line.row(i) << i, 2 * i, 3 * i;
  EXPECT_THROW(register_landmarks(line, line), Error);
}

// Presses of one point, conditioned already: push = stiffness * depth.
Conditioned linear_press(double stiffness_N_m, double speed_m_s) {
  Conditioned r;
  r.is_axial = true, r.inward = Vec3(0, 0, -1), r.contact_m = Vec3(0.01, 0, 0),
  r.speed_m_s = speed_m_s;
  r.hysteresis = r.young_Pa = std::numeric_limits<double>::quiet_NaN(), r.apparent_Pa = 1e4,
  r.noise_N = 1e-3;
  r.deflection_m = r.force_N = Points::Zero(20, 3), r.error_N = Eigen::VectorXd::Constant(20, 1e-3);
  for (int i = 0; i < 20; ++i)
    r.deflection_m(i, 0) = 1e-4 * (i + 1), r.force_N(i, 0) = stiffness_N_m * r.deflection_m(i, 0);
  r.status.assign(20, RowStatus::good);
  return r;
}

Assembled assembled(const std::vector<Conditioned>& presses, const AssembleOptions& options = {}) {
  std::vector<BatchItem> items(presses.size());
  std::vector<ItemResult> results(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    items[i].file = items[i].shown = "p" + std::to_string(i) + ".csv", items[i].point = "p";
    results[i].recordings = {presses[i]}, results[i].is_done = true;
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

TEST(pooling, recordings_off_the_surface_are_refused_with_their_distance) {
  const Surface surface = bumpy_sheet();
  Conditioned off = linear_press(1000, 1e-3);
  off.contact_m = Vec3(0.05, 0.05, 0.03);
  Conditioned on = linear_press(1000, 1e-3);
  on.contact_m = surface.vertices.row(50);
  AssembleOptions options;
  options.surface = &surface;
  const Assembled out = assembled({on, off}, options);
  EXPECT_FALSE(out.outcomes[0].failure);
  ASSERT_TRUE(out.outcomes[1].failure);
  EXPECT_NE(out.outcomes[1].failure->what.find("mm from the surface"), std::string::npos);
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
