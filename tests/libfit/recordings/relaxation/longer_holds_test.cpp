// Better recordings tell more: longer holds, more readings, free parts.

#include <gtest/gtest.h>

#include <cstdio>

#include "libfit/recordings/relaxation/bed_response.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"
#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

constexpr int kSeeds = 20;

struct HoldCase {
  Relaxation relaxation;
  double held_s, rate_Hz, before_s, after_s, slope;
  double ramp_s = 0.4;
  int least_within = 16;  // of 20 seeds, each of shares, times and psi
};

std::vector<HoldCase> hold_cases() {
  const Relaxation one = prony({0.5}, {3}), two = prony({0.6, 0.4}, {0.3, 4}),
                   three = prony({0.5, 0.5, 0.5}, {0.1, 1, 10});
  return {{two, 5, 100, 2, 0.5, 0},     {two, 20, 100, 2, 0.5, 0},
          {two, 60, 100, 2, 0.5, 0},    {two, 120, 100, 2, 0.5, 0},
          {two, 60, 20, 2, 0.5, 0},     {two, 60, 10, 2, 0.5, 0, 2},
          {two, 20, 1000, 2, 0.5, 0},   {three, 60, 100, 2, 2, 0},
          {three, 120, 100, 2, 2, 0},   {one, 20, 100, 5, 0, 0.01},
          {one, 20, 100, 5, 0, 0.02},   {one, 20, 100, 5, 0, 0.05},
          {one, 20, 100, 5, 0, 0.1},    {one, 20, 100, 5, 10, 0.1},
          {one, 60, 10, 5, 0, 0.05, 2}, {two, 60, 100, 10, 0, 0.05},
          {one, 20, 100, 0.5, 0, 0.05}, {two, 20, 100, 5, 0, -0.05, 0.4, 14}};
}

// Of the seeds: right number of branches; of those, shares and times in their bands; psi at 0.1, 1
// and 10 s in its band. 95 % of 20 are 19, and 16 or fewer come by chance once in 60. A hold of
// five times the slow branch tells it little from a drift that falls as it does: of that 14 are
// asked for.
TEST(LongerHolds, tell_more) {
  std::printf(
      "| branches | hold, s | Hz | free before, after, s | drift | branches found: 0, 1, 2, 3 | "
      "shares and times within | psi within | rms error of psi, %% "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  for (const HoldCase& c : hold_cases()) {
    const Eigen::Index branches = c.relaxation.branches();
    std::array<int, runtime::kMaxBranches + 1> found{};
    std::vector<int> within(static_cast<std::size_t>(2 * branches), 0);
    const Eigen::VectorXd times = Eigen::Vector3d(0.1, 1, 10);
    const Eigen::VectorXd truth = stiffening(c.relaxation, times);
    std::array<int, 3> stiff{};
    std::array<double, 3> squares{};
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const RecoveryCase way{"",
                             c.relaxation,
                             {long_hold_way(c.before_s, c.held_s, c.after_s, c.ramp_s)},
                             {0.01, 0, c.slope}};
      const RelaxationFit fit = fit_relaxation(
          {presses_of(way, seed, 1 / c.rate_Hz, std::max(1, static_cast<int>(200 / c.rate_Hz)))});
      ++found[static_cast<std::size_t>(fit.relaxation.branches())];
      const auto band = fit.band(times);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const auto at = static_cast<std::size_t>(i);
        stiff[at] += truth[i] >= band.low[i] - 1e-9 && truth[i] <= band.high[i] + 1e-9;
        squares[at] += std::pow(band.middle[i] / truth[i] - 1, 2) / kSeeds;
      }
      if (fit.relaxation.branches() != branches) continue;
      for (Eigen::Index k = 0; k < branches; ++k) {
        const double share = c.relaxation.share[k], time_s = c.relaxation.time_s[k];
        within[static_cast<std::size_t>(2 * k)] +=
            share >= fit.share_low[k] && share <= fit.share_high[k];
        within[static_cast<std::size_t>(2 * k + 1)] +=
            time_s >= fit.time_low_s[k] && time_s <= fit.time_high_s[k];
      }
    }
    std::printf("| %d | %g | %g | %g, %g | %g %% | %d, %d, %d, %d |", static_cast<int>(branches),
                c.held_s, c.rate_Hz, c.before_s, c.after_s, 100 * c.slope, found[0], found[1],
                found[2], found[3]);
    for (const int n : within) std::printf(" %d", n);
    std::printf(" | %d %d %d |", stiff[0], stiff[1], stiff[2]);
    for (const double square : squares) std::printf(" %.2g", 100 * std::sqrt(square));
    std::printf(" |\n");
    std::fflush(stdout);
    const int right = found[static_cast<std::size_t>(branches)];
    EXPECT_GE(right, kSeeds * 9 / 10) << "hold " << c.held_s << " s, " << c.rate_Hz << " Hz";
    for (const int n : within)
      EXPECT_GE(n, c.least_within - (kSeeds - right))
          << "hold " << c.held_s << " s, " << c.rate_Hz << " Hz, drift " << c.slope;
    for (const int n : stiff)
      EXPECT_GE(n, c.least_within)
          << "hold " << c.held_s << " s, " << c.rate_Hz << " Hz, drift " << c.slope;
    // Whatever is added to a recording of 20 s leaves the stiffening as well known.
    for (const double square : squares)
      EXPECT_LT(std::sqrt(square), c.held_s < 10 ? 0.04 : 0.025)
          << "hold " << c.held_s << " s, " << c.rate_Hz << " Hz, drift " << c.slope;
  }
}

}  // namespace
}  // namespace palpate::recordings
