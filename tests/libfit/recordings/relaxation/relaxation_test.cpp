#include <gtest/gtest.h>

#include <Eigen/LU>

#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "libfit/recordings/relaxation/align_contacts.hpp"
#include "libfit/recordings/relaxation/bed_response.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"
#include "libfit/recordings/relaxation/least_squares.hpp"
#include "libfit/recordings/relaxation/sensor_noise.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

// A path at equal intervals.
std::pair<Eigen::VectorXd, Eigen::VectorXd> sampled(const Way& way, double interval_s) {
  const auto rows = static_cast<Eigen::Index>(way.time_s.back() / interval_s) + 1;
  Eigen::VectorXd time_s(rows), depth_m(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    time_s[i] = interval_s * static_cast<double>(i);
    depth_m[i] = way.depth_at(time_s[i]);
  }
  return {time_s, depth_m};
}

TEST(BedResponse, is_lee_and_radoks_integral_while_the_contact_grows) {
  const Relaxation r = prony({0.7, 0.4, 2}, {0.02, 0.5, 7});
  const double speed = 2e-3, in_s = 1.5;
  Way way;
  way.go(0, 0), way.go(speed * in_s, in_s), way.go(speed * in_s, 4);
  const auto [time_s, depth_m] = sampled(way, 0.05);
  const Eigen::VectorXd rings = Eigen::Vector3d(0, 0.7e-3, 2.1e-3);
  const Eigen::MatrixXd forces = ring_forces(time_s, depth_m, r, rings);
  for (Eigen::Index i = 0; i < time_s.size(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double t = time_s[i], from = rings[k] / speed, to = std::min(t, in_s);
      double expected = 0;  // of psi(t - s) speed ds from `from` to `to`
      if (t > from) {
        expected = speed * (to - from);
        for (Eigen::Index b = 0; b < 3; ++b)
          expected += speed * r.share[b] * r.time_s[b] *
                      (std::exp(-(t - to) / r.time_s[b]) - std::exp(-(t - from) / r.time_s[b]));
      }
      EXPECT_NEAR(forces(i, k), expected, 1e-14) << "at " << t << " s, ring " << k;
    }
}

TEST(BedResponse, equals_small_steps_where_rings_let_go_and_come_back) {
  const Relaxation r = prony({0.7, 0.4}, {0.1, 1.5});
  Way way;  // in, held, quickly half out, in again, out, a second touch before it forgets
  way.go(-1e-3, 0), way.go(3e-3, 1), way.go(3e-3, 1), way.go(1e-3, 0.05), way.go(2e-3, 0.4);
  way.go(-1e-3, 0.1), way.go(2.5e-3, 0.5);
  const auto [time_s, depth_m] = sampled(way, 0.05);
  const std::vector<double> reference = forces({r, 1}, way, 0.05, 400);
  // The same rings as there.
  constexpr int kRings = 150;
  Eigen::VectorXd ring(kRings), stiffness(kRings);
  const auto begin = [&](int i) { return 3e-3 * i * i / kRings / kRings; };
  const auto slope = [&](int i) {
    return (std::pow(begin(i + 1) / 1e-3, 1.5) - std::pow(begin(i) / 1e-3, 1.5)) /
           (begin(i + 1) - begin(i));
  };
  for (int i = 0; i < kRings; ++i)
    ring[i] = begin(i), stiffness[i] = slope(i) - (i > 0 ? slope(i - 1) : 0);
  const Eigen::MatrixXd each = ring_forces(time_s, depth_m, r, ring);
  EXPECT_GE(each.minCoeff(), 0);
  const Eigen::VectorXd sum = each * stiffness;
  const double most_N = sum.maxCoeff();
  for (Eigen::Index i = 0; i < sum.size(); ++i)
    EXPECT_NEAR(sum[i], reference[static_cast<std::size_t>(i)], 2e-3 * most_N) << time_s[i] << " s";
}

TEST(BedResponse, places_on_a_straight_way_change_nothing) {
  const Relaxation r = prony({3, 0.4, 0.2}, {0.05, 0.3, 4});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> depth(-1e-3, 3e-3), duration(0.01, 2);
  Way way;
  way.go(-1e-3, 0);
  for (int i = 0; i < 40; ++i) way.go(depth(random), duration(random));
  const auto n = static_cast<Eigen::Index>(way.time_s.size());
  Eigen::VectorXd time_s(n), depth_m(n), fine_s(4 * n - 3), fine_m(4 * n - 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    time_s[i] = way.time_s[static_cast<std::size_t>(i)];
    depth_m[i] = way.depth_m[static_cast<std::size_t>(i)];
  }
  for (Eigen::Index i = 0; i < fine_s.size(); ++i) {
    const double share = static_cast<double>(i % 4) / 4;
    const Eigen::Index a = i / 4, b = std::min(a + 1, n - 1);
    fine_s[i] = (1 - share) * time_s[a] + share * time_s[b];
    fine_m[i] = (1 - share) * depth_m[a] + share * depth_m[b];
  }
  const Eigen::VectorXd rings = Eigen::VectorXd::LinSpaced(9, 0, 2.5e-3);
  const Eigen::MatrixXd coarse = ring_forces(time_s, depth_m, r, rings),
                        fine = ring_forces(fine_s, fine_m, r, rings);
  for (Eigen::Index i = 0; i < n; ++i)
    EXPECT_LT((coarse.row(i) - fine.row(4 * i)).cwiseAbs().maxCoeff(), 1e-12) << "place " << i;
}

TEST(LeastSquares, meets_the_conditions_of_a_minimum_without_negative_weights) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(30, 12, [&] { return normal(random); });
    a.col(3) = a.col(7);
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(30, [&] { return normal(random); });
    const Eigen::VectorXd x = nonnegative_least_squares(a.transpose() * a, a.transpose() * b);
    const Eigen::VectorXd slope = a.transpose() * (b - a * x);
    EXPECT_GE(x.minCoeff(), 0) << "seed " << seed;
    EXPECT_LE(slope.maxCoeff(), 1e-8) << "seed " << seed;
    EXPECT_NEAR(slope.dot(x), 0, 1e-8) << "seed " << seed;
  }
}

// Coefficients of a level, a slope and a decay, by least squares that knows nothing of drift.
TEST(SensorNoise, tells_how_far_a_fit_may_be_off_with_white_noise_and_with_drift) {
  const Eigen::Index n = 120;
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(n, 0, 20),
                        one = Eigen::VectorXd::Ones(n);
  Eigen::MatrixXd slopes(n, 3);
  slopes << one, time_s, (-time_s.array() / 4).exp().matrix();
  const Eigen::MatrixXd inverse = (slopes.transpose() * slopes).inverse();
  for (const double drift : {0., 1., 4.}) {
    Eigen::Vector3d squares = Eigen::Vector3d::Zero(), wide = squares;
    constexpr int kSeeds = 150;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> normal(0, 1);
      const std::vector<double> slow = slow_noise(static_cast<std::size_t>(n), random);
      const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index i) {
        return normal(random) + drift * slow[static_cast<std::size_t>(i)];
      });
      const Eigen::Vector3d off = inverse * slopes.transpose() * noise;
      const Eigen::MatrixXd covariance =
          inverse * slopes.transpose() *
          sensor_covariance(time_s, one, one, noise - slopes * off, slopes) * slopes * inverse;
      squares += off.cwiseAbs2().cwiseQuotient(covariance.diagonal()) / kSeeds;
      wide += covariance.diagonal() / kSeeds;
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(std::sqrt(squares[k]), 0.7) << "drift " << drift << ", coefficient " << k;
      EXPECT_LT(std::sqrt(squares[k]), 1.2) << "drift " << drift << ", coefficient " << k;
      if (drift == 0) {  // what may be drift and is not costs at most half of the width
        EXPECT_LT(std::sqrt(wide[k] / inverse(k, k)), 1.5) << "coefficient " << k;
      }
    }
  }
}

// Contacts found 0.3 mm too early and 0.2 mm too late, with deviations that say so.
TEST(Contacts, of_one_point_are_aligned_by_the_curve_they_share) {
  const Relaxation body = prony({0.5}, {1});
  std::vector<RelaxingPress> presses;
  for (const auto& [duration_s, off_m] : {std::pair{8., -3e-4}, {0.8, 2e-4}, {2., 0.}}) {
    std::mt19937 random(7);
    const auto raw = record({body, 1}, ramp_way(duration_s), 0.01, 2, {0.002, 0}, random);
    SignalSettings settings;
    settings.known_contact = {1e-3 + off_m, 3e-4};
    const Conditioned done = condition(raw, settings, std::nullopt, "press.csv", false);
    presses.push_back({done.history, done.noise_N, 3e-4});
  }
  const auto aligned = align_contacts(presses, body, SlowCurve::powers).contact;
  ASSERT_EQ(aligned.size(), 3u);
  EXPECT_NEAR(aligned[1].moved_m - aligned[0].moved_m, -5e-4, 1e-5);
  EXPECT_NEAR(aligned[2].moved_m - aligned[0].moved_m, -3e-4, 1e-5);
  // Three readings of one contact: their mean.
  EXPECT_NEAR(aligned[2].moved_m, -1e-4 / 3, 1e-5);
  for (const ContactShift& one : aligned) EXPECT_NEAR(one.deviation_m, 3e-4 / std::sqrt(3), 2e-6);
  for (RelaxingPress& press : presses) press.contact_deviation_m = 0;  // where the rig knows it
  for (const ContactShift& one : align_contacts(presses, body, SlowCurve::powers).contact) {
    EXPECT_EQ(one.moved_m, 0);
    EXPECT_EQ(one.deviation_m, 0);
  }
}

TEST(TimedPress, keeps_corners_and_means_of_a_recording) {
  std::mt19937 random(3);
  const auto raw = record({prony({0.5}, {3}), 1}, hold_way(), 0.01, 2, {0.002, 0}, random);
  SignalSettings settings;
  settings.radius_m = 5e-3;
  const Conditioned done = condition(raw, settings, std::nullopt, "press.csv", false);
  const TimedPress& p = done.history;
  ASSERT_GT(p.rows(), 50);
  EXPECT_LT(p.rows(), 250);
  EXPECT_GT(held_share(p), 0.8);
  const double touch_s = 0.5 + (done.contact.travel_m - 1e-3) / 2e-3;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    if (i > 0) {
      EXPECT_GT(p.time_s[i], p.time_s[i - 1]);
    }
    // On the way, straight between its corners.
    EXPECT_NEAR(p.depth_m[i],
                hold_way().depth_at(p.time_s[i] + touch_s) + 1e-3 - done.contact.travel_m, 1e-9)
        << "row " << i;
  }
}

TEST(Relaxation, is_found_with_the_branches_that_the_recordings_hold) {
  for (const std::size_t number : {std::size_t{2}, std::size_t{5}}) {  // a hold; two rates
    const RecoveryCase c = recovery_cases()[number];
    const RelaxationFit fit = fit_relaxation({presses_of(c, 1)});
    ASSERT_EQ(fit.relaxation.branches(), c.relaxation.branches()) << c.name;
    for (Eigen::Index k = 0; k < c.relaxation.branches(); ++k) {
      // Twice the 95 % band: one seed of many.
      const double share = fit.share_high[k] / fit.relaxation.share[k],
                   time = fit.time_high_s[k] / fit.relaxation.time_s[k];
      EXPECT_LT(std::abs(std::log(fit.relaxation.share[k] / c.relaxation.share[k])),
                2 * std::log(share))
          << c.name;
      EXPECT_LT(std::abs(std::log(fit.relaxation.time_s[k] / c.relaxation.time_s[k])),
                2 * std::log(time))
          << c.name;
      EXPECT_LT(share, 1.4) << c.name;
    }
    EXPECT_LT(fit.rms_N, 0.02 * fit.pictures[0][0].push_N.maxCoeff());
  }
}

TEST(Relaxation, is_none_where_a_body_has_none) {
  const RelaxationFit fit = fit_relaxation({presses_of(recovery_cases()[0], 1)});
  EXPECT_EQ(fit.relaxation.branches(), 0);
  EXPECT_GE(fit.held_out.size(), 2u);
}

TEST(Relaxation, slower_than_the_recording_is_said) {
  const RecoveryCase c{"", prony({1}, {400}), {hold_way(10)}, {0.003, 0}};
  const RelaxationFit fit = fit_relaxation({presses_of(c, 2)});
  for (Eigen::Index k = 0; k < fit.relaxation.branches(); ++k)
    EXPECT_LE(fit.relaxation.time_s[k], fit.longest_s * (1 + 1e-9));
  if (fit.relaxation.branches() > 0) {
    EXPECT_TRUE(fit.is_slower.back());
    EXPECT_TRUE(std::isinf(fit.time_high_s[fit.relaxation.branches() - 1]));
  }
}

// Rows of a long hold were too long for its fast branch: 60 s at 20 Hz told one branch of 2 s, and
// a stiffening that was 13 % off at 0.1 s.
TEST(Relaxation, of_a_longer_hold_is_told_no_worse) {
  const RecoveryCase c{"", prony({0.6, 0.4}, {0.3, 4}), {long_hold_way(2, 60, 0.5)}, {}};
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RelaxationFit fit = fit_relaxation({presses_of(c, seed, 0.05, 10)});
    EXPECT_GE(fit.relaxation.branches(), 2) << "seed " << seed;
    const Eigen::VectorXd times = Eigen::Vector3d(0.1, 1, 10);
    const Eigen::VectorXd off =
        fit.band(times).middle.cwiseQuotient(stiffening(c.relaxation, times)).array() - 1;
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.03) << "seed " << seed << ": " << off.transpose();
  }
}

// What a sensor drifts by is known from its free part, as well as that tells it: a drift of 10 %
// put the stiffening 8 % off, and into no band.
TEST(Relaxation, a_drift_is_told_by_the_free_part_before_contact) {
  for (const double slope : {-0.1, 0.1})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RecoveryCase c{"", prony({0.5}, {3}), {long_hold_way(5, 20, 0)}, {0.01, 0, slope}};
      const RelaxationFit fit = fit_relaxation({presses_of(c, seed)});
      ASSERT_EQ(fit.relaxation.branches(), 1) << "seed " << seed;
      const Eigen::VectorXd times = Eigen::Vector3d(0.1, 1, 10);
      const auto band = fit.band(times);
      const Eigen::VectorXd truth = stiffening(c.relaxation, times);
      for (Eigen::Index i = 0; i < 3; ++i) {
        EXPECT_NEAR(band.middle[i], truth[i], 0.015 * truth[i]) << "seed " << seed;
        // Twice the 95 % band: one seed of many.
        EXPECT_LT(std::abs(band.middle[i] - truth[i]), 2 * (band.high[i] - band.middle[i]))
            << "seed " << seed << ", drift " << slope << ", at " << times[i] << " s";
      }
    }
}

TEST(Relaxation, its_band_is_the_covariance_carried_to_the_stiffening) {
  RelaxationFit fit;
  fit.relaxation = prony({0.6, 0.4}, {0.5, 6});
  fit.covariance = Eigen::MatrixXd::Zero(4, 4);
  fit.covariance.diagonal() << 0.01, 0.02, 0.03, 0.04;
  fit.covariance(0, 2) = fit.covariance(2, 0) = -0.012;
  const Eigen::VectorXd time_s = Eigen::Vector3d(0, 0.7, 5);
  const auto band = fit.band(time_s);
  for (Eigen::Index i = 0; i < 3; ++i) {
    Eigen::VectorXd by(4);
    for (Eigen::Index k = 0; k < 4; ++k) {
      const auto at = [&](double step) {
        Relaxation r = fit.relaxation;
        (k < 2 ? r.share[k] : r.time_s[k - 2]) *= std::exp(step);
        return stiffening(r, time_s)[i];
      };
      by[k] = (at(1e-5) - at(-1e-5)) / 2e-5;
    }
    EXPECT_NEAR(band.high[i] - band.middle[i], 1.96 * std::sqrt(by.dot(fit.covariance * by)), 1e-8);
  }
}

// In to 2 mm in `in_s`, then deeper as a held force sinks: creep to (1 + share)^{2/3} times that.
Way creep_way(double share, double time_s, double held_s, double in_s = 0.2) {
  Way way;
  way.go(-1e-3, 0), way.go(0, 0.1), way.go(2e-3, in_s);
  for (double t = 0.05; t < held_s; t += std::max(0.05, 0.1 * t))
    way.go(2e-3 * std::pow(1 + share - share * std::exp(-t / ((1 + share) * time_s)), 2.0 / 3),
           std::max(0.05, 0.1 * (t - 0.05)));
  way.go(-1e-3, 1), way.go(-1e-3, 1);
  return way;
}

TEST(TimedPress, tells_a_force_that_is_held_from_a_depth_that_is) {
  struct Case {
    std::string name;
    RelaxingBody body;
    Way way;
    bool is_creep;
  };
  Way slow = ramp_way(60), yields;
  yields.go(-1e-3, 0), yields.go(3e-3, 4), yields.go(-1e-3, 4);
  const RelaxingBody elastic{prony({}, {}), 1};
  const std::vector<Case> cases{
      {"creep", {prony({0.5}, {3}), 1}, creep_way(0.5, 3, 30), true},
      {"creep of a tenth", {prony({0.1}, {5}), 1}, creep_way(0.1, 5, 30), true},
      {"creep after a slow way in", {prony({0.5}, {20}), 1}, creep_way(0.5, 20, 60, 2), true},
      {"hold", {prony({0.5}, {3}), 1}, hold_way(), false},
      {"hold of what does not relax", elastic, hold_way(), false},
      {"stairs", {prony({0.6, 0.4}, {0.3, 4}), 1}, stairs_way(), false},
      {"slow way in", elastic, slow, false},
      {"slow way in, relaxing", {prony({0.5}, {3}), 1}, slow, false}};
  for (const Case& c : cases)
    for (unsigned seed = 1; seed <= 10; ++seed)
      for (const double noise : {0.0, 0.01, 0.02}) {
        const auto presses =
            presses_of({c.name, c.body.relaxation, {c.way}, {noise, noise / 2}}, seed, 0.02);
        EXPECT_EQ(is_creep(presses[0].press), c.is_creep)
            << c.name << ", noise " << noise << ", seed " << seed;
      }
  // What yields while the tool goes on as fast: the force stays, and no controller holds it.
  TimedPress yielding = presses_of({"", {}, {yields}, {0, 0}}, 1)[0].press;
  yielding.push_N = yielding.push_N.cwiseMin(0.4 * yielding.push_N.maxCoeff());
  EXPECT_FALSE(is_creep(yielding));
}

// A sensor of steps shows one value for seconds while the tool sinks. Once the free part before a
// long hold was too short to be seen, and what is free was "saturated over 100 %".
TEST(TimedPress, a_coarse_sensor_s_held_force_is_not_saturated) {
  std::mt19937 random(3);
  auto raw = record({prony({0.5}, {3}), 1}, creep_way(0.5, 3, 30), 0.02, 2, {0, 0}, random);
  const double step_N = 0.02 * *std::ranges::max_element(raw.push_N);
  for (double& push_N : raw.push_N) push_N = step_N * std::round(push_N / step_N);
  const auto done = condition(raw, {.radius_m = 5e-3}, std::nullopt, "press.csv", false);
  EXPECT_TRUE(is_creep(done.history));
  for (const RowStatus status : done.status) EXPECT_EQ(status, RowStatus::good);
}

class RelaxationImport : public testing_io::ScratchTest {
 protected:
  // A recording as a file and its entry.
  BatchItem item_of(const importers::RawRecording& raw, const std::string& name) const {
    BatchItem item;
    item.file = folder_ / name;
    std::ofstream out(item.file);
    out << "t,z,f\n";
    for (std::size_t k = 0; k < raw.time_s.size(); ++k)
      out << raw.time_s[k] << "," << 1e3 * raw.travel_m[k] << "," << raw.push_N[k] << "\n";
    item.shown = item.file.filename();
    item.point = "p";
    item.position_m = Vec3::Zero();
    item.normal = Vec3(0, 0, -1);
    item.read.columns.time = "t", item.read.columns.depth = "z", item.read.columns.force = {"f"};
    item.read.units = {"s", "mm", "N"};
    item.read.is_force_on_tool = false;
    item.signal.radius_m = 5e-3;
    return item;
  }
};

TEST_F(RelaxationImport, gives_rows_in_time_and_keeps_rates_apart) {
  // Two repeats at one speed, which would be pooled, with a hold.
  std::vector<BatchItem> items;
  const RecoveryCase c = recovery_cases()[1];
  for (int i = 0; i < 2; ++i) {
    std::mt19937 random(static_cast<unsigned>(40 + i));
    items.push_back(item_of(record({c.relaxation, 1}, c.ways[0], 0.01, 2, {0.003, 0}, random),
                            "hold" + std::to_string(i) + ".csv"));
  }
  BatchOptions batch;
  batch.jobs = 1;
  const auto results = run_batch(items, batch, Progress{});
  const Assembled found = assemble(items, results, {});
  for (const Outcome& outcome : found.outcomes)
    ASSERT_FALSE(outcome.failure) << outcome.failure->what;
  ASSERT_TRUE(found.relaxation);
  const Samples& samples = found.samples;
  ASSERT_EQ(samples.relaxation.branches(), 1);
  EXPECT_NEAR(samples.relaxation.share[0], 0.5, 0.03);
  EXPECT_NEAR(samples.relaxation.time_s[0], 3, 0.3);
  ASSERT_EQ(samples.time_s.size(), samples.rows());
  EXPECT_EQ(samples.experiment.back(), 1);
  EXPECT_GT(samples.time_s.maxCoeff(), 20);
  EXPECT_NE(found.notes.at(0).find("relaxation"), std::string::npos);
  for (const Eigen::Index r : {0, 1}) {  // both touch after 1 mm
    EXPECT_EQ(samples.recordings.estimator[static_cast<std::size_t>(r)], "auto: hertz, aligned");
    EXPECT_NEAR(samples.recordings.contact_m[r], 1e-3,
                3 * samples.recordings.contact_deviation_m[r]);
    EXPECT_LT(samples.recordings.contact_deviation_m[r], 5e-5);
  }
  EXPECT_NEAR(samples.recordings.contact_m[0], samples.recordings.contact_m[1], 2e-5);

  write_samples(folder_ / "samples.h5", samples, {});
  const Samples back = read_samples(folder_ / "samples.h5");
  EXPECT_EQ(back.time_s, samples.time_s);
  write_relaxation(folder_ / "relaxation.csv", *found.relaxation);

  AssembleOptions none;
  none.relaxation = RelaxationUse::none;
  const Assembled pooled = assemble(items, results, none);
  EXPECT_EQ(pooled.samples.time_s.size(), 0);
  EXPECT_EQ(pooled.samples.experiment.back(), 0);
}

// The depth creeps as d^{3/2} = 1 + g - g e^{-t/((1 + g) tau)} times that at first.
TEST_F(RelaxationImport, of_a_press_whose_force_stays_while_it_creeps_finds_the_series) {
  constexpr double kShare = 0.5, kTime_s = 3, kSeconds = 30;
  std::mt19937 random(7);
  const auto raw = record({prony({kShare}, {kTime_s}), 1}, creep_way(kShare, kTime_s, kSeconds),
                          0.01, 2, {0.003, 0}, random);
  const std::vector<BatchItem> items{item_of(raw, "creep.csv")};
  BatchOptions batch;
  batch.jobs = 1;
  const Assembled found = assemble(items, run_batch(items, batch, Progress{}), {});
  for (const Outcome& outcome : found.outcomes)
    ASSERT_FALSE(outcome.failure) << outcome.failure->what;
  ASSERT_TRUE(found.relaxation);
  const Samples& samples = found.samples;
  ASSERT_EQ(samples.relaxation.branches(), 1);
  EXPECT_NEAR(samples.relaxation.share[0], kShare, 0.05);
  EXPECT_NEAR(samples.relaxation.time_s[0], kTime_s, 0.5);
  ASSERT_EQ(samples.time_s.size(), samples.rows());
  EXPECT_GT(samples.time_s.maxCoeff(), 20);
  EXPECT_EQ(found.relaxation->creeping, 1);
  EXPECT_NE(found.notes.front().find("creep: 1 whose force is held"), std::string::npos)
      << found.notes.front();
}

// A body that goes on relaxing where the recordings end, and one whose points differ: rows in time
// would be worse than the mean of repeats (once 153 % against 66 of points left out).
TEST_F(RelaxationImport, what_is_doubted_is_proposed_and_not_applied) {
  std::vector<BatchItem> slow, uneven;
  std::mt19937 random(11);
  for (int i = 0; i < 2; ++i) {
    slow.push_back(item_of(record({prony({2}, {60}), 1}, hold_way(10), 0.01, 2, {0.003, 0}, random),
                           "slow" + std::to_string(i) + ".csv"));
    uneven.push_back(item_of(
        record({prony({i == 0 ? 0.3 : 1.2}, {2}), 1}, hold_way(20), 0.01, 2, {0.003, 0}, random),
        "uneven" + std::to_string(i) + ".csv"));
    uneven.back().point = "p" + std::to_string(i);
    uneven.back().position_m = Vec3(0.01 * i, 0, 0);
  }
  BatchOptions batch;
  batch.jobs = 1;
  for (const auto& [items, doubt] :
       {std::pair{slow, std::string("a branch is slower than the recordings")},
        {uneven, std::string("points do not relax alike")}}) {
    const auto results = run_batch(items, batch, Progress{});
    const Assembled proposed = assemble(items, results, {});
    ASSERT_TRUE(proposed.relaxation);
    EXPECT_GT(proposed.relaxation->fit.relaxation.branches(), 0) << doubt;
    EXPECT_EQ(proposed.relaxation->doubts, std::vector<std::string>{doubt});
    EXPECT_FALSE(proposed.relaxation->is_applied);
    EXPECT_EQ(proposed.samples.relaxation.branches(), 0);
    EXPECT_EQ(proposed.samples.time_s.size(), 0);
    const bool is_said = std::ranges::any_of(proposed.notes, [&](const std::string& note) {
      return note.starts_with("relaxation is proposed, not applied: " + doubt);
    });
    EXPECT_TRUE(is_said) << doubt;
    AssembleOptions always;
    always.relaxation = RelaxationUse::always;
    const Assembled applied = assemble(items, results, always);
    EXPECT_TRUE(applied.relaxation->is_applied);
    EXPECT_GT(applied.samples.relaxation.branches(), 0);
    EXPECT_EQ(applied.samples.time_s.size(), applied.samples.rows());
  }
}

}  // namespace
}  // namespace palpate::recordings
