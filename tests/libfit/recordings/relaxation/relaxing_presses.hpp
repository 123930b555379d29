#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"

// Presses of a sphere on a bed of rings that relaxes, as a rig would record them. The bed is
// integrated here by small explicit steps, apart from the code under test.
namespace palpate::testing_relaxation {

/// A way of the tool: places over time, straight between them. Depth 0 is contact.
struct Way {
  std::vector<double> time_s, depth_m;

  void go(double depth, double duration_s) {
    time_s.push_back((time_s.empty() ? 0 : time_s.back()) + duration_s);
    depth_m.push_back(depth);
  }
  double depth_at(double t) const {
    std::size_t i = 1;
    while (i + 1 < time_s.size() && time_s[i] < t) ++i;
    const double share = (t - time_s[i - 1]) / (time_s[i] - time_s[i - 1]);
    return depth_m[i - 1] + share * (depth_m[i] - depth_m[i - 1]);
  }
};

/// Force of Hertz at 1 mm [N], and rings of its bed.
struct RelaxingBody {
  Relaxation relaxation;
  double hertz_N = 1;
};

/// Forces along a way at equal intervals, by small steps of every ring.
inline std::vector<double> forces(const RelaxingBody& body, const Way& way, double interval_s,
                                  int steps_each) {
  constexpr int kRings = 150;
  double deepest_m = 0;
  for (const double d : way.depth_m) deepest_m = std::max(deepest_m, d);
  const auto hertz = [&](double d) { return body.hertz_N * std::pow(std::max(0., d) / 1e-3, 1.5); };
  std::vector<double> begin(kRings + 1), stiffness(kRings);
  for (int i = 0; i <= kRings; ++i) begin[i] = deepest_m * i * i / kRings / kRings;
  for (int i = 0; i < kRings; ++i) {
    const auto slope = [&](int k) {
      return (hertz(begin[k + 1]) - hertz(begin[k])) / (begin[k + 1] - begin[k]);
    };
    stiffness[i] = slope(i) - (i > 0 ? slope(i - 1) : 0);
  }
  const auto branches = static_cast<int>(body.relaxation.branches());
  std::vector<std::vector<double>> v(kRings, std::vector<double>(3, 0));
  double all = 0;
  for (int k = 0; k < branches; ++k) all += body.relaxation.share[k];
  std::vector<double> out;
  const double end_s = way.time_s.back(), dt = interval_s / steps_each;
  std::vector<double> decay(3, 0);
  for (int k = 0; k < branches; ++k) decay[k] = 1 - std::exp(-dt / body.relaxation.time_s[k]);
  for (int row = 0; row * interval_s <= end_s; ++row) {
    double sum = 0;
    for (int s = row == 0 ? steps_each - 1 : 0; s < steps_each; ++s) {
      const double t = std::max(0., (row - 1) * interval_s + (s + 1) * dt),
                   before = way.depth_at(std::max(0., t - dt / 2)), depth = way.depth_at(t);
      sum = 0;
      for (int i = 0; i < kRings; ++i) {
        double held = 0;
        for (int k = 0; k < branches; ++k) held += body.relaxation.share[k] * v[i][k];
        const double y = std::max(before - begin[i], held / (1 + all));
        for (int k = 0; k < branches; ++k) v[i][k] += (y - v[i][k]) * decay[k];
        held = 0;
        for (int k = 0; k < branches; ++k) held += body.relaxation.share[k] * v[i][k];
        sum += stiffness[i] * std::max(0., (1 + all) * (depth - begin[i]) - held);
      }
    }
    out.push_back(sum);
  }
  return out;
}

/// What a sensor adds: white noise, and a drift whose power goes as 1/f; shares of the largest
/// force, standard deviations of a reading. slope: what a drift that goes straight adds over the
/// recording, a share of the largest force.
struct Sensor {
  double noise = 0.01, drift = 0, slope = 0;
};

/// Sum of slow oscillators of equal power per octave: 1/f from the length of the recording to four
/// readings, standard deviation 1.
inline std::vector<double> slow_noise(std::size_t rows, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  std::vector<double> out(rows, 0);
  double squares = 0;
  for (double period = 2 * static_cast<double>(rows); period > 4; period /= 1.5) {
    const double a = normal(random), b = normal(random);
    for (std::size_t i = 0; i < rows; ++i) {
      const double phase = 2 * M_PI * static_cast<double>(i) / period;
      out[i] += a * std::cos(phase) + b * std::sin(phase);
    }
    squares += 1;
  }
  for (double& value : out) value /= std::sqrt(squares);
  return out;
}

/// A recording along one axis, travel from 0 where the way begins.
inline importers::RawRecording record(const RelaxingBody& body, const Way& way, double interval_s,
                                      int steps_each, const Sensor& sensor, std::mt19937& random) {
  importers::RawRecording raw;
  raw.push_N = forces(body, way, interval_s, steps_each);
  const double most_N = *std::max_element(raw.push_N.begin(), raw.push_N.end());
  std::normal_distribution<double> normal(0, sensor.noise * most_N);
  const auto drift = slow_noise(raw.push_N.size(), random);
  for (std::size_t i = 0; i < raw.push_N.size(); ++i) {
    const double t = interval_s * static_cast<double>(i);
    raw.time_s.push_back(t);
    raw.travel_m.push_back(way.depth_at(t) - way.depth_m[0]);
    raw.push_N[i] += normal(random) + sensor.drift * most_N * drift[i] +
                     sensor.slope * most_N * t / way.time_s.back();
    raw.line.push_back(i + 2);
  }
  return raw;
}

inline Relaxation prony(std::vector<double> share, std::vector<double> time_s) {
  const auto n = static_cast<Eigen::Index>(share.size());
  return {Eigen::Map<Eigen::VectorXd>(share.data(), n),
          Eigen::Map<Eigen::VectorXd>(time_s.data(), n)};
}

/// 3 mm in at 2 mm/s from 1 mm above, held, and out again.
inline Way hold_way(double held_s = 20) {
  Way way;
  way.go(-1e-3, 0), way.go(3e-3, 2), way.go(3e-3, held_s), way.go(-1e-3, 2), way.go(-1e-3, 2);
  return way;
}
/// Four stairs of 0.75 mm, 5 s each.
inline Way stairs_way() {
  Way way;
  way.go(-1e-3, 0);
  for (int i = 0; i < 4; ++i)
    way.go((i + 1) * 0.75e-3, i > 0 ? 0.3 : 0.7), way.go((i + 1) * 0.75e-3, 5);
  way.go(-1e-3, 2), way.go(-1e-3, 1);
  return way;
}
/// In and out without a stand.
inline Way ramp_way(double duration_s) {
  Way way;
  way.go(-1e-3, 0), way.go(3e-3, duration_s), way.go(-1e-3, duration_s);
  return way;
}

/// In to 2 mm in `in_s`, then deeper as a held force sinks: creep to (1 + share)^{2/3} times that.
inline Way creep_way(double share, double time_s, double held_s, double in_s = 0.2) {
  Way way;
  way.go(-1e-3, 0), way.go(0, 0.1), way.go(2e-3, in_s);
  for (double t = 0.05; t < held_s; t += std::max(0.05, 0.1 * t))
    way.go(2e-3 * std::pow(1 + share - share * std::exp(-t / ((1 + share) * time_s)), 2.0 / 3),
           std::max(0.05, 0.1 * (t - 0.05)));
  way.go(-1e-3, 1), way.go(-1e-3, 1);
  return way;
}

/// A body and the ways in which it is pressed: recordings of one point.
struct RecoveryCase {
  std::string name;
  Relaxation relaxation;
  std::vector<Way> ways;
  Sensor sensor;
};

inline std::vector<RecoveryCase> recovery_cases() {
  const Relaxation none, one = prony({0.5}, {3}), two = prony({0.6, 0.4}, {0.5, 6}),
                         three = prony({0.8, 0.5, 0.5}, {0.15, 1.2, 9});
  const Sensor white{0.01, 0}, drifting{0.01, 0.01};
  return {{"hold, none", none, {hold_way()}, drifting},
          {"hold, 1 branch", one, {hold_way()}, white},
          {"hold, 2 branches", two, {hold_way()}, white},
          {"hold, 3 branches", three, {hold_way()}, white},
          {"stairs, 2 branches", prony({0.6, 0.4}, {0.3, 4}), {stairs_way()}, white},
          {"two rates, 1 branch", prony({0.5}, {1}), {ramp_way(8), ramp_way(0.8)}, white},
          {"hold, 1 branch, 1/f drift", one, {hold_way()}, drifting},
          {"hold, 2 branches, 1/f drift", two, {hold_way()}, drifting}};
}

/// Free for a while, 4 mm in, 3 of them in contact, held, and out to be free again.
inline Way long_hold_way(double before_s, double held_s, double after_s, double ramp_s = 0.4) {
  Way way;
  way.go(-1e-3, 0), way.go(-1e-3, before_s), way.go(3e-3, ramp_s), way.go(3e-3, held_s);
  way.go(-1e-3, ramp_s), way.go(-1e-3, after_s);
  return way;
}

/// Recordings of a case, conditioned as an import does: the contact point is not known.
inline std::vector<recordings::TimedPress> presses_of(const RecoveryCase& of, unsigned seed,
                                                      double interval_s = 0.01,
                                                      int steps_each = 2) {
  std::mt19937 random(seed);
  std::vector<recordings::TimedPress> presses;
  for (const Way& way : of.ways) {
    const auto raw = record({of.relaxation, 1}, way, interval_s, steps_each, of.sensor, random);
    recordings::SignalSettings settings;
    settings.radius_m = 5e-3;
    const auto done = recordings::condition(raw, settings, std::nullopt, "press.csv");
    recordings::TimedPress& press = presses.emplace_back(done.history);
    press.noise_N = done.noise_N, press.contact_deviation_m = done.contact.deviation_m;
  }
  return presses;
}

}  // namespace palpate::testing_relaxation
