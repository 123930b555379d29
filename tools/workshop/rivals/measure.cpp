#include "tools/workshop/rivals/measure.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/workshop/bench/tick_timing.hpp"

namespace palpate::tools {
namespace {

constexpr double kJumpWay_m = 10e-6;
// A tick after one this long is timed by the thread's own processor time, which is told less
// finely; shorter ones by the clock, and those of a row during which the processor was taken away
// are left out.
constexpr double kLong_ns = 100e3;
constexpr validation::ProcessorClock::time_point kNever{};

// A rival along a path, tick by tick.
class RivalWalk {
 public:
  RivalWalk(const Rival& rival, const Vec3& inward, const Vec3& outside)
      : rival_(rival), at_m_(outside) {
    rival_.start(inward);
    tick();
  }

  void go(const Vec3& to, double step_m) {
    const Vec3 from = at_m_;
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step_m)));
    const std::size_t timed = contact_ns_.size();
    watch_.was_switched();
    for (int k = 1; k <= steps; ++k) {
      at_m_ = from + (to - from) * (double(k) / steps);
      tick();
    }
    if (watch_.was_switched() && !is_long_) contact_ns_.resize(timed);
  }

  // Its ticks' time counts as that of all.
  void rest(RestCount& count) {
    come_to_rest(
        rival_, [&] { return tick(); }, count);
  }

  const Vec3& force_N() const { return force_N_; }
  const WorkAccount& account() const { return account_; }
  const std::vector<double>& contact_ns() const { return contact_ns_; }
  double largest_change_N() const { return largest_change_N_; }
  void forget_changes() { largest_change_N_ = 0; }

 private:
  Vec3 tick() {
    const Vec3 before_N = force_N_;
    const double own_s = rival_.own_cpu_s ? rival_.own_cpu_s() : 0;
    const auto began = is_long_ ? validation::ProcessorClock::now() : kNever;
    const double started = now_ns();
    force_N_ = rival_.force(at_m_);
    double ns = now_ns() - started;
    if (rival_.own_cpu_s)
      ns = 1e9 * (rival_.own_cpu_s() - own_s);
    else if (is_long_)
      ns = static_cast<double>((validation::ProcessorClock::now() - began).count());
    is_long_ = rival_.own_cpu_s || ns > kLong_ns;
    if (!force_N_.isZero()) contact_ns_.push_back(ns);
    largest_change_N_ = std::max(largest_change_N_, (force_N_ - before_N).norm());
    account_.add(at_m_, force_N_);
    return force_N_;
  }

  const Rival& rival_;
  Vec3 at_m_, force_N_ = Vec3::Zero();
  WorkAccount account_;
  std::vector<double> contact_ns_;
  double largest_change_N_ = 0;
  bool is_long_ = false;
  SwitchWatch watch_;
};

struct PathPlace {
  Eigen::Index first, count;
  Vec3 position, inward;

  Vec3 outside(double depth_m) const { return position - kApproachRatio * depth_m * inward; }
};

std::vector<PathPlace> paths_of(const Samples& paths) {
  std::vector<PathPlace> out;
  for (Eigen::Index row = 0; row < paths.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (row > 0 && paths.experiment[r] == paths.experiment[r - 1]) {
      ++out.back().count;
      continue;
    }
    const Eigen::Index point = paths.point[r];
    out.push_back({row, 1, paths.point_position.row(point), paths.point_normal.row(point)});
  }
  return out;
}

Vec3 place_of(const Samples& paths, const PathPlace& path, Eigen::Index step) {
  return path.position + Vec3(paths.deflection.row(path.first + step));
}

void follow_path(const Rival& rival, const RivalBody& body, const PathPlace& path,
                 Replayed& replayed, std::vector<double>& contact_ns, Performance& out) {
  RivalWalk walk(rival, path.inward, path.outside(body.depth_m));
  for (Eigen::Index step = 0; step < path.count; ++step) {
    walk.go(place_of(body.paths, path, step), rival.step_m);
    walk.rest(out.rest);
    replayed.force_N.row(path.first + step) = walk.force_N();
    replayed.is_answered[path.first + step] = 1;
  }
  // Out as far as it went in, and a depth beyond: a surface that was dragged along has let go.
  const Vec3 last = place_of(body.paths, path, path.count - 1);
  const double depth_m = std::max(0.0, (last - path.position).dot(path.inward));
  walk.go(last - (depth_m + body.depth_m) * path.inward, rival.step_m);
  const WorkAccount& account = walk.account();
  if (account.peak_J() > 0)
    out.created_share = std::max(out.created_share, -account.work_J() / account.peak_J());
  contact_ns.insert(contact_ns.end(), walk.contact_ns().begin(), walk.contact_ns().end());
}

void slide_finely(const Rival& rival, const RivalBody& body, const PathPlace& path,
                  const std::function<bool()>& is_over, Performance& out) {
  RivalWalk walk(rival, path.inward, path.outside(body.depth_m));
  Eigen::Index step = 0;
  for (; step < path.count / 2; ++step) walk.go(place_of(body.paths, path, step), rival.step_m);
  walk.forget_changes();
  for (; step < path.count && !is_over(); ++step) {
    walk.go(place_of(body.paths, path, step), kJumpWay_m);
    out.jump_N = std::fmax(out.jump_N, walk.largest_change_N());
  }
}

}  // namespace

void WorkAccount::add(const Vec3& place_m, const Vec3& force_N) {
  if (!is_first_) work_J_ += 0.5 * (force_N + force_N_).dot(place_m - place_m_);
  is_first_ = false;
  place_m_ = place_m, force_N_ = force_N;
  peak_J_ = std::max(peak_J_, work_J_);
}

Performance measure(const Rival& rival, const RivalBody& body, double budget_s) {
  Performance out;
  Replayed replayed(body.paths);
  std::vector<double> contact_ns;
  const std::vector<PathPlace> paths = paths_of(body.paths);
  const double began_s = spent_s(rival);
  for (const PathPlace& path : paths) {
    if (out.paths > 0 && spent_s(rival) - began_s > budget_s) break;
    follow_path(rival, body, path, replayed, contact_ns, out);
    ++out.paths;
  }
  const validation::ErrorFloors floors{relative_floor_N(body.paths)};
  const validation::Comparison compared = validation::compare(body.paths, replayed);
  out.statement = validation::summarize(compared, floors);
  out.by_path = validation::errors_by(
      compared, floors, std::span(kPathKindNames).first(kUprightKinds),
      [&](Eigen::Index row) { return static_cast<std::size_t>(body.paths.path_of(row)); });
  const double clock = clock_ns();
  out.tick_median_us = 1e-3 * std::max(0.0, quantile(contact_ns, 0.5) - clock);
  out.tick_p999_us = 1e-3 * std::max(0.0, quantile(contact_ns, 0.999) - clock);
  if (rival.is_force_at_rest) {
    out.created_share = validation::kNoNumber;
    return out;
  }
  const double slides_from_s = spent_s(rival);
  const auto is_over = [&] { return spent_s(rival) - slides_from_s > budget_s / 3; };
  for (const PathPlace& path : paths)
    if (body.paths.path_of(path.first) == PathKind::sliding && !is_over())
      slide_finely(rival, body, path, is_over, out);
  return out;
}

}  // namespace palpate::tools
