// Bodies that are solved or superposed are given the modulus that suits them best, as people do.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/stated_error.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {
namespace {

constexpr std::int32_t kFittedPresses = 8;
constexpr int kTicksOfPress = 40;
constexpr double kFitBudget_s = 4;
constexpr double kStill = 0.005, kSlow = 0.05;  // change of a force, of itself
constexpr int kSteadyTicks = 10;

struct PressedPair {
  double wanted_N, answered_N;
};

// How many ticks a force has stayed within a share of what it was at the first of them.
struct SteadyForce {
  double share;
  Vec3 first = Vec3::Zero();
  int ticks = -1;

  void add(const Vec3& force) {
    const bool stays = ticks >= 0 && (force - first).norm() <= share * force.norm();
    ticks = stays ? ticks + 1 : 0;
    if (!stays) first = force;
  }
};

// Forces along the presses' rows, wanted and answered.
std::vector<PressedPair> press_with(const Rival& rival, const RivalBody& body, RestCount& rest) {
  const Samples& samples = body.samples;
  const double floor_N = relative_floor_N(samples), tick_m = body.depth_m / kTicksOfPress;
  const auto every =
      std::max<std::int32_t>(1, static_cast<std::int32_t>(samples.points()) / kFittedPresses);
  std::vector<PressedPair> out;
  double at_m = 0;
  const double began_s = spent_s(rival);
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (samples.kind[r] != ExperimentKind::press || samples.point[r] % every != 0) continue;
    const Vec3 position = samples.point_position.row(samples.point[r]),
               inward = samples.point_normal.row(samples.point[r]);
    if (row == 0 || samples.experiment[r] != samples.experiment[r - 1]) {
      if (!out.empty() && spent_s(rival) - began_s > kFitBudget_s) break;
      rival.start(inward);
      at_m = -kApproachRatio * body.depth_m;
    }
    const double depth_m = Vec3(samples.deflection.row(row)).dot(inward);
    Vec3 force = Vec3::Zero();
    while (at_m < depth_m) {
      at_m = std::min(depth_m, at_m + tick_m);
      force = rival.force(position + at_m * inward);
    }
    come_to_rest(
        rival, [&] { return force = rival.force(position + at_m * inward); }, rest);
    if (rest.rows > 1 && !rest.is_kept() && spent_s(rival) - began_s > kFitBudget_s) break;
    const double wanted_N = Vec3(samples.force.row(row)).dot(inward);
    if (samples.status[r] == RowStatus::good && wanted_N > floor_N && force.dot(inward) > 0)
      out.push_back({wanted_N, force.dot(inward)});
  }
  return out;
}

double best_factor(const std::vector<PressedPair>& pairs) {
  double best = 1, least = std::numeric_limits<double>::infinity();
  for (const PressedPair& candidate : pairs) {
    const double factor = candidate.wanted_N / candidate.answered_N;
    double sum = 0;
    for (const PressedPair& pair : pairs)
      sum += std::abs(factor * pair.answered_N - pair.wanted_N) / pair.wanted_N;
    if (sum < least) least = sum, best = factor;
  }
  return best;
}

}  // namespace

std::string RestCount::words(const char* of, int ticks) const {
  return fmt::format("{} of the {} rows of its {} came to rest in {} ticks", rested, rows, of,
                     ticks);
}

void come_to_rest(const Rival& rival, const std::function<Vec3()>& tick, RestCount& count) {
  if (rival.rest_ticks == 0) return;
  SteadyForce still{kStill}, slow{kSlow};
  for (int k = 0; k < rival.rest_ticks && still.ticks < kSteadyTicks; ++k) {
    const Vec3 force = tick();
    still.add(force);
    slow.add(force);
  }
  ++count.rows;
  count.rested += slow.ticks >= kSteadyTicks;
}

double spent_s(const Rival& rival) { return rival.own_cpu_s ? rival.own_cpu_s() : cpu_seconds(); }

Rival with_fitted_modulus(Rival rival, const RivalBody& body) {
  const double began_s = spent_s(rival);
  const double factor = best_factor(press_with(rival, body, rival.rest));
  rival.preparation_cpu_s += spent_s(rival) - began_s + kFittedPresses * body.pressed_cpu_s;
  rival.settings += fmt::format("; modulus x {:.3g}, of {} presses", factor, kFittedPresses);
  rival.modulus = factor;
  rival.force = [force = std::move(rival.force), factor](const Vec3& point) -> Vec3 {
    return factor * force(point);
  };
  return rival;
}

}  // namespace palpate::tools
