#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

TEST(Relaxation, is_found_with_the_branches_that_the_recordings_hold) {
  for (const std::size_t number : {std::size_t{2}, std::size_t{5}}) {  // a hold; two rates
    const RecoveryCase c = recovery_cases()[number];
    const std::vector<TimedPress> presses = presses_of(c, 1);
    const RelaxationFit fit = fit_relaxation({presses});
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
    EXPECT_LT(fit.rms_N, 0.02 * presses[0].push_N.maxCoeff());
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

}  // namespace
}  // namespace palpate::recordings
