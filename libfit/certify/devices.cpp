#include "libfit/certify/devices.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace palpate::certify {
namespace {

constexpr double kNoticeable_N = 0.04;  // smallest change of a force that a hand feels
constexpr double kApproach_s = 0.3, kRest_s = 1, kWatch_s = 0.3;
constexpr int kSubsteps = 20;  // of a tick

struct Hand {
  double mass_kg, damping_Ns_m, stiffness_N_m;
};

Hand draw_hand(std::mt19937_64& random) {
  const auto draw = [&](double least, double most) {
    const double share = double(random() >> 11) * 0x1p-53;
    return least * std::pow(most / least, share);
  };
  const double mass_kg = draw(0.05, 0.3), damping_Ns_m = draw(1, 10);
  return {mass_kg, damping_Ns_m, draw(50, 800)};
}

// Peak-to-peak force that is sent to the device over the last kWatch_s.
double swing_N(const Device& device, const Hand& hand, double stiffness_N_m, double press_N,
               const ServoLoop& loop) {
  const double step_s = 1 / loop.rate_Hz / kSubsteps, mass_kg = device.mass_kg + hand.mass_kg;
  const double there_m = press_N / stiffness_N_m + press_N / hand.stiffness_N_m;
  const auto ticks = static_cast<int>((kApproach_s + kRest_s + kWatch_s) * loop.rate_Hz);
  double x = -0.002, v = 0, least_N = 1e300, most_N = 0;
  std::vector<double> sent_N(loop.delay_ticks + 1, 0.0);
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = tick / loop.rate_Hz, come = std::min(1.0, t / kApproach_s);
    const double aim_m = -0.002 + (there_m + 0.002) * come * come * (3 - 2 * come);
    const double read_m =
        device.resolution_m > 0 ? std::floor(x / device.resolution_m) * device.resolution_m : x;
    double force_N = std::max(0.0, stiffness_N_m * read_m);
    if (device.max_force_N > 0) force_N = std::min(force_N, device.max_force_N);
    std::rotate(sent_N.begin(), sent_N.end() - 1, sent_N.end());
    sent_N.front() = force_N;
    if (t > kApproach_s + kRest_s) {
      least_N = std::min(least_N, force_N);
      most_N = std::max(most_N, force_N);
    }
    for (int i = 0; i < kSubsteps; ++i) {
      const double pull_N =
          hand.stiffness_N_m * (aim_m - x) - hand.damping_Ns_m * v - sent_N.back();
      const double free = v + pull_N * step_s / mass_kg;
      const double slowed = std::abs(free) - device.friction_N * step_s / mass_kg;
      v = slowed > 0 ? std::copysign(slowed, free) : 0;
      x += v * step_s;
    }
  }
  return most_N - least_N;
}

}  // namespace

int swinging_hands(const Device& device, double stiffness_N_m, double force_N,
                   const ServoLoop& loop) {
  std::mt19937_64 random(loop.seed);
  const double most_N = device.max_force_N > 0 ? std::min(force_N, device.max_force_N) : force_N;
  int swinging = 0;
  for (int i = 0; i < loop.hands; ++i)
    swinging +=
        swing_N(device, draw_hand(random), stiffness_N_m, 0.5 * most_N, loop) > kNoticeable_N;
  return swinging;
}

double least_damping_Ns_m(double stiffness_N_m, double rate_Hz) {
  return 0.5 * stiffness_N_m / rate_Hz;  // (M23)
}

DeviceVerdict judge(const Device& device, double stiffness_N_m, double force_N) {
  DeviceVerdict out{device};
  out.force_fits = device.max_force_N == 0 || force_N <= device.max_force_N;
  out.stiffness_fits = device.max_stiffness_N_m == 0 || stiffness_N_m <= device.max_stiffness_N_m;
  out.resolution_fits = device.friction_N == 0 || device.resolution_m == 0 ||
                        0.5 * stiffness_N_m * device.resolution_m <= device.friction_N;  // (M24)
  if (device.mass_kg > 0 && stiffness_N_m > 0) {
    out.hands = ServoLoop().hands;
    out.swinging = swinging_hands(device, stiffness_N_m, force_N);
  }
  return out;
}

}  // namespace palpate::certify
