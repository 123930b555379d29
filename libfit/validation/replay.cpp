#include "libfit/validation/replay.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/walk.hpp"
#include "libfit/validation/tick_time.hpp"

namespace palpate::validation {
namespace {

constexpr double kMaxTick_s = 1e-3;
constexpr double kLeastTick_s = runtime::kMinTimeStep_s;
constexpr double kSlowTick_s = runtime::kMaxTimeStep_s;

class TipWalk {
 public:
  explicit TipWalk(const runtime::AssetView& asset) : body_(asset) {}

  // What the engine says at each deflection of a path. A path without times is followed so slowly
  // that dashpots of a body that relaxes do.
  std::vector<runtime::Output> answers(const HeldOut& held_out, std::size_t path, double depth_m) {
    contact_ = runtime::Contact();
    asset_ = &body_.fresh();
    const Vec3 point = held_out.points.position.row(path),
               normal = held_out.points.normal.row(path);
    const Points& deflections = held_out.paths[path].deflections;
    const Eigen::VectorXd& time_s = held_out.paths[path].time_s;
    Vec3 deflection = -kApproachRatio * depth_m * normal;
    std::vector<runtime::Output> answers;
    runtime::Output out = tick(point + deflection, kSlowTick_s);
    for (Eigen::Index row = 0; row < deflections.rows(); ++row) {
      const Vec3 from = deflection, way = Vec3(deflections.row(row)) - from;
      const bool is_timed = time_s.size() > 0;
      const double dt_s = is_timed ? time_s[row] - (row > 0 ? time_s[row - 1] : 0) : 0;
      const int steps = std::max(
          1, static_cast<int>(std::ceil(std::max(way.norm() / kWalkTick_m, dt_s / kMaxTick_s))));
      for (int k = 1; k <= steps; ++k)
        out = tick(point + from + way * (double(k) / steps), is_timed ? dt_s / steps : kSlowTick_s);
      deflection = deflections.row(row);
      answers.push_back(out);
    }
    return answers;
  }

  std::size_t ticks() const { return ticks_; }

 private:
  runtime::Output tick(const Vec3& tip, double dt_s) {
    runtime::Output out;  // a status but ok comes with zero force
    runtime::touch(*asset_, contact_, tip.data(), out, nullptr, std::max(dt_s, kLeastTick_s));
    ++ticks_;
    return out;
  }

  WalkedBody body_;  // new for each path
  const runtime::AssetView* asset_ = nullptr;
  runtime::Contact contact_;
  std::size_t ticks_ = 0;
};

// Rows of each experiment of a point that can be replayed, in step order.
std::map<std::int32_t, std::vector<Eigen::Index>> usable_rows(const Samples& samples,
                                                              std::int32_t point) {
  std::map<std::int32_t, std::vector<Eigen::Index>> usable;
  std::map<std::int32_t, bool> has_ended;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    if (samples.point[row] != point) continue;
    const bool is_good = samples.status[row] == RowStatus::good;
    bool& ended = has_ended[samples.experiment[row]];
    if (is_good && !ended) usable[samples.experiment[row]].push_back(row);
    if (!is_good && samples.kind[row] != ExperimentKind::press) ended = true;
  }
  return usable;
}

}  // namespace

Replayed::Replayed(const Samples& reference)
    : force_N(Points::Zero(reference.rows(), 3)),
      torque_Nm(force_N),
      is_sliding(reference.rows(), 0),
      is_answered(is_sliding) {}

void replay_path(const runtime::AssetView& asset, const Reference& reference, std::size_t path,
                 double depth_m, Replayed& replayed) {
  const auto answers = TipWalk(asset).answers(reference.held_out, path, depth_m);
  for (Eigen::Index row = 0; row < reference.paths.rows(); ++row) {
    if (reference.paths.point[row] != static_cast<std::int32_t>(path)) continue;
    const runtime::Output& out = answers[reference.paths.step[row]];
    const Vec3 force = -Eigen::Map<const Vec3>(out.force_on_tool_N);
    const Vec3 tip = (reference.held_out.points.position.row(static_cast<Eigen::Index>(path)) +
                      reference.paths.deflection.row(row))
                         .transpose();
    replayed.force_N.row(row) = force.transpose();
    replayed.torque_Nm.row(row) =
        (Eigen::Map<const Vec3>(out.acts_at_m) - tip).cross(force).transpose();
    replayed.is_sliding[row] = out.state == runtime::ContactState::slip;
    replayed.is_answered[row] = 1;
  }
}

Replayed replay_paths(const runtime::AssetView& asset, const Reference& reference, double depth_m) {
  Replayed replayed(reference.paths);
  for (std::size_t path = 0; path < reference.held_out.paths.size(); ++path)
    replay_path(asset, reference, path, depth_m, replayed);
  return replayed;
}

void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed) {
  const fit::Bases bases = fit::bases_of(curves);
  const runtime::Quadric quadric =
      fit::quadric_of(samples.point_normal.row(point), fit::offset_gradient(samples, point));
  const runtime::ControlPointers<double> controls = fit::controls_at(curves, row);
  for (const auto& [experiment, rows] : usable_rows(samples, point)) {
    std::vector<double> deflection_m, time_s;
    for (const Eigen::Index i : rows) {
      for (int k = 0; k < 3; ++k) deflection_m.push_back(samples.deflection(i, k));
      if (samples.time_s.size() > 0) time_s.push_back(samples.time_s[i]);
    }
    std::vector<runtime::Vec3d> force(rows.size());
    runtime::replay_drag<double>(bases.views, controls, quadric,
                                 {deflection_m.data(), static_cast<int>(rows.size()),
                                  time_s.empty() ? nullptr : time_s.data()},
                                 nullptr, force.data());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      replayed.force_N.row(rows[i]) << force[i].x, force[i].y, force[i].z;
      replayed.is_answered[rows[i]] = 1;
    }
  }
}

std::vector<ComparedRow> compare(const Samples& reference, const Points& answer_N,
                                 const std::function<bool(Eigen::Index)>& counts) {
  std::vector<ComparedRow> rows;
  for (Eigen::Index row = 0; row < reference.rows(); ++row)
    if (reference.status[row] == RowStatus::good && counts(row))
      rows.push_back({reference.force.row(row), answer_N.row(row), reference.force_error[row]});
  return rows;
}

std::vector<ComparedRow> compare(const Samples& reference, const Replayed& replayed) {
  return compare(reference, replayed.force_N,
                 [&](Eigen::Index row) { return replayed.is_answered[row] != 0; });
}

double time_ticks_ns(const runtime::AssetView& asset, const HeldOut& held_out, double depth_m) {
  TipWalk walk(asset);
  return tick_ns([&] {
    const std::size_t before = walk.ticks();
    for (std::size_t path = 0; path < held_out.paths.size(); ++path)
      walk.answers(held_out, path, depth_m);
    return walk.ticks() - before;
  });
}

}  // namespace palpate::validation
