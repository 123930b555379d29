// A rig with truth: contact points of presses whose law of force is known, beside what is stated.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "libfit/recordings/batch/batch.hpp"

#ifndef RIG_SEEDS
#define RIG_SEEDS 8
#endif

namespace palpate::recordings {
namespace {

constexpr double kDepth_m = 4e-3, kContact_m = 2e-3;
constexpr double kYoung_Pa = 10e3 / 0.75;  // E* of an incompressible body of 10 kPa

// Force over Hertz' at a depth, as a share of the largest one, and at sqrt(R d) [m].
struct ForceLaw {
  const char* name;
  double (*factor)(double share, double contact_radius_m);
};

// Dimitriadis et al. (2002), doi:10.1016/S0006-3495(02)75620-8: a layer bonded to a rigid bed.
double on_rigid_bed(double contact_radius_m, double height_m) {
  const double x = contact_radius_m / height_m;
  return 1 + x * (1.133 + x * (1.283 + x * (0.769 + x * 0.0975)));
}

constexpr ForceLaw kLaws[] = {
    {"Hertz", [](double, double) { return 1.0; }},
    {"stiffens by 20 %", [](double x, double) { return 1 + 0.2 * x; }},
    {"stiffens by 40 %", [](double x, double) { return 1 + 0.4 * x; }},
    {"stiffens by 100 %", [](double x, double) { return 1 + x; }},
    {"softens by 15 %", [](double x, double) { return 1 - 0.15 * x; }},
    {"softens by 30 %", [](double x, double) { return 1 - 0.3 * x; }},
    {"15 mm on a stiff layer", [](double, double a) { return on_rigid_bed(a, 15e-3); }},
    {"exponential", [](double x, double) { return std::exp(1.5 * x); }},
};

struct Rig {
  double noise_N = 10e-3, radius_m = 5e-3;
  std::size_t readings = 600;
  Tip tip = Tip::sphere;
};

// A press over 6 mm of travel with its contact within half a millimetre of 2 mm.
Conditioned press(const ForceLaw& law, const Rig& rig, unsigned seed, double& contact_m) {
  std::mt19937 random(seed);
  contact_m = kContact_m + std::uniform_real_distribution<double>(-0.5e-3, 0.5e-3)(random);
  std::normal_distribution<double> noise(0, rig.noise_N);
  importers::RawRecording raw;
  raw.name = law.name;
  for (std::size_t i = 0; i < rig.readings; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(rig.readings - 1);
    const double depth_m = std::max(0.0, 6e-3 * share - contact_m);
    const double root_m = std::sqrt(rig.radius_m * depth_m);
    const double power_m2 = rig.tip == Tip::sphere ? 4.0 / 3 * root_m * depth_m
                            : rig.tip == Tip::flat ? 2 * rig.radius_m * depth_m
                                                   : 2 / M_PI * depth_m * depth_m;
    raw.time_s.push_back(6 * share);
    raw.travel_m.push_back(6e-3 * share);
    raw.push_N.push_back(kYoung_Pa * power_m2 * law.factor(depth_m / kDepth_m, root_m) +
                         noise(random));
    raw.line.push_back(i + 1);
  }
  SignalSettings settings;
  settings.radius_m = rig.radius_m;
  settings.tip = rig.tip;
  return condition(raw, settings, std::nullopt, law.name);
}

struct Score {
  int presses = 0, within_two = 0;
  double squares = 0, stated = 0;
  double rms_m() const { return std::sqrt(squares / presses); }
  double stated_m() const { return std::sqrt(stated / presses); }
};

Score score(const ForceLaw& law, const Rig& rig, int seeds) {
  Score out;
  for (int seed = 0; seed < seeds; ++seed) {
    double contact_m = 0;
    const Conditioned found = press(law, rig, static_cast<unsigned>(seed), contact_m);
    const double off_m = found.contact.travel_m - contact_m;
    ++out.presses;
    out.within_two += std::abs(off_m) <= 2 * found.contact.deviation_m;
    out.squares += off_m * off_m;
    out.stated += found.contact.deviation_m * found.contact.deviation_m;
  }
  std::printf("%-22s %4.0f mN, %4.1f mm, %4zu readings: rms %6.1f um, stated %6.1f um, %d of %d\n",
              law.name, 1e3 * rig.noise_N, 1e3 * rig.radius_m, rig.readings, 1e6 * out.rms_m(),
              1e6 * out.stated_m(), out.within_two, out.presses);
  return out;
}

// None to two of sixteen were within two deviations, and off by 0.2 to 0.4 mm, when the power law
// alone was fitted to as long a range as it explained.
TEST(contact_rig, a_body_that_stiffens_or_softens_has_its_contact_within_what_is_stated) {
  int within = 0, presses = 0;
  for (const ForceLaw& law : kLaws) {
    const Score found = score(law, {}, 2 * RIG_SEEDS);
    within += found.within_two, presses += found.presses;
    EXPECT_GE(found.within_two, 0.8 * found.presses) << law.name;
    EXPECT_LT(found.rms_m(), 0.1e-3) << law.name;
    EXPECT_LT(found.stated_m(), 2 * found.rms_m()) << law.name;
  }
  EXPECT_GE(within, 0.9 * presses);
}

TEST(contact_rig, other_noises_balls_and_rates_are_stated_as_well) {
  int within = 0, presses = 0;
  for (const ForceLaw& law : kLaws)
    for (const Rig& rig : {Rig{.noise_N = 2e-3}, Rig{.noise_N = 30e-3}, Rig{.radius_m = 2.5e-3},
                           Rig{.radius_m = 10e-3}, Rig{.readings = 120}, Rig{.readings = 6000}}) {
      const Score found = score(law, rig, RIG_SEEDS);
      within += found.within_two, presses += found.presses;
    }
  EXPECT_GE(within, 0.9 * presses);
}

TEST(contact_rig, a_cone_and_a_flat_tip_are_stated_as_well) {
  int within = 0, presses = 0;
  for (const ForceLaw& law : kLaws)
    for (const Tip tip : {Tip::cone, Tip::flat}) {
      const Score found = score(law, {.tip = tip}, RIG_SEEDS);
      within += found.within_two, presses += found.presses;
    }
  EXPECT_GE(within, 0.9 * presses);
}

}  // namespace
}  // namespace palpate::recordings
