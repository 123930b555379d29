// The contact point of the shared cases' recordings, read as `palpate import` reads them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "libfit/recordings/batch/batch.hpp"
#include "tests/libfit/recordings/case_recordings.hpp"
#include "tests/libfit/recordings/contact_bounds.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_recordings;

struct Score {
  int cases = 0, covered = 0, refused = 0;
  double worst_m = 0, squares = 0, stated_m = 0;
  void add(double error_m, double deviation_m) {
    ++cases;
    covered += std::abs(error_m) <= 3 * deviation_m;
    worst_m = std::max(worst_m, std::abs(error_m));
    squares += error_m * error_m;
    stated_m += deviation_m * deviation_m;
  }
  double rms_m() const { return std::sqrt(squares / std::max(1, cases)); }
  double stated_rms_m() const { return std::sqrt(stated_m / std::max(1, cases)); }
};

class ContactOfCases : public testing::Test {
 protected:
  void SetUp() override { PALPATE_NEEDS_DATA("cases/curves"); }
};

struct Told {
  const char* shown;
  const char* truth;
  double radius_m;  // of the tip, where it is told
};
constexpr Told kTold[] = {{"T1_cubic", "T1_cubic", 0}, {"T3_toe_linear", "T3_toe_linear", 0},
                          {"T5_hertz", "T5_hertz", 0}, {"T5, tip told", "T5_hertz", 5e-3},
                          {"T6_soft", "T6_soft", 0},   {"T8_paper_eq6", "T8_paper_eq6", 0},
                          {"T9_snap", "T9_snap", 0}};

TEST_F(ContactOfCases, the_bounds_are_those_of_the_cases) {
  EXPECT_NEAR(contact_bound_m("T1_cubic", {0.005, 0, 0}, true), 7.466e-6, 0.01e-6);
  EXPECT_NEAR(contact_bound_m("T5_hertz", {0.01, 0, 0}, true), 8.485e-6, 0.03e-6);
}

// All cycles of a recording, both ways, as the bounds count them. A bound of the cases (three
// deviations of an estimator that knows the shape) that no estimator without it can keep gives way
// to three deviations of the best one without.
TEST_F(ContactOfCases, errors_are_within_what_the_readings_can_tell) {
  Score all;
  int kept = 0, not_kept = 0, outside = 0;
  std::printf("um: error +- stated | bound of the cases, shape unknown (three deviations)\n");
  for (const char* noise : kCaseNoises)
    for (const Told& told : kTold) {
      BatchItem item = case_item(told.truth, noise);
      item.signal.use = Use::mean;
      item.signal.radius_m = told.radius_m;
      item.signal.is_range_given = true;
      item.signal.min_young_Pa = 0;
      item.signal.max_young_Pa = 1e15;
      const auto results = run_batch({item}, {}, {});
      ASSERT_TRUE(results[0].refused.empty())
          << told.truth << " " << noise << ": " << results[0].refused[0].failure.where() << ": "
          << results[0].refused[0].failure.fact();
      const Conditioned& r = results[0].recordings[0];
      const double off_m = r.contact.travel_m - case_contact_m(told.truth, noise);
      all.add(off_m, r.contact.deviation_m);
      const Noise kind = noise_of(noise);
      if (kind.white == 0) {
        std::printf("%-10s | %-14s | %7.1f +- %6.1f |\n", noise, told.shown, 1e6 * off_m,
                    1e6 * r.contact.deviation_m);
        EXPECT_LT(std::abs(off_m), 20e-6) << told.shown << ": half a row apart";
        continue;
      }
      const double bound_m = 3 * contact_bound_m(told.truth, kind, true),
                   unknown_m =
                       told.radius_m > 0 ? bound_m : 3 * contact_bound_m(told.truth, kind, false);
      const bool is_kept = std::abs(off_m) <= bound_m;
      kept += is_kept;
      not_kept += !is_kept;
      outside += std::abs(off_m) > unknown_m;
      std::printf("%-10s | %-14s | %7.1f +- %6.1f | %6.1f %7.1f | %s\n", noise, told.shown,
                  1e6 * off_m, 1e6 * r.contact.deviation_m, 1e6 * bound_m, 1e6 * unknown_m,
                  is_kept                        ? "inside"
                  : std::abs(off_m) <= unknown_m ? "as told"
                                                 : "OUTSIDE");
    }
  std::printf(
      "%d inside the cases' bound, %d not; %d of %d within 3 stated deviations, rms %.1f "
      "um, stated %.1f um\n",
      kept, not_kept, all.covered, all.cases, 1e6 * all.rms_m(), 1e6 * all.stated_rms_m());
  EXPECT_GE(kept, 18);
  EXPECT_LE(outside, 1) << "three deviations of 49: 0.13 are expected";
  EXPECT_GE(all.covered, 0.95 * all.cases);
  EXPECT_LT(all.stated_rms_m(), 2 * all.rms_m());
}

// The same truths under 25 draws of each level of noise, 201 rows of the way in.
TEST_F(ContactOfCases, the_stated_deviation_covers_over_seeded_noise) {
  constexpr unsigned kSeed = 20;
  constexpr int kDraws = 25;
  Score all;
  for (const double share : {0.0025, 0.01}) {
    for (const char* truth : kCaseTruths) {
      Score score;
      for (unsigned draw = 0; draw < kDraws; ++draw) {
        const Conditioned r =
            condition(noisy_press(truth, share, kSeed + draw), {}, Vec3(0, 0, -1), truth);
        score.add(r.contact.travel_m, r.contact.deviation_m);
        all.add(r.contact.travel_m, r.contact.deviation_m);
      }
      std::printf(
          "%-14s noise %.2f %%: rms %6.1f um, stated %6.1f um, worst %6.1f, %d of %d "
          "within 3\n",
          truth, 100 * share, 1e6 * score.rms_m(), 1e6 * score.stated_rms_m(), 1e6 * score.worst_m,
          score.covered, score.cases);
      EXPECT_LT(score.stated_rms_m(), 10 * score.rms_m()) << truth << " seed " << kSeed;
    }
  }
  EXPECT_GE(all.covered, 0.95 * all.cases) << "seed " << kSeed;
}

}  // namespace
}  // namespace palpate::recordings
