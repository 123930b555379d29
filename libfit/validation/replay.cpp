#include "libfit/validation/replay.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/experiments.hpp"
#include "libfit/fit/point/local_curves.hpp"
#include "libfit/validation/tick_time.hpp"

namespace palpate::validation {
namespace {

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
  const auto& point = reference.paths.point;
  const auto begin = std::ranges::find(point, static_cast<std::int32_t>(path));
  const auto end =
      std::find_if(begin, point.end(), [&](std::int32_t p) { return p != std::int32_t(path); });
  const Eigen::Index first = begin - point.begin(), count = end - begin;
  const FollowedRows rows = follow(asset, row_range(reference.paths, first, count), depth_m);
  replayed.force_N.middleRows(first, count) = rows.force_N;
  replayed.torque_Nm.middleRows(first, count) = rows.torque_Nm;
  std::ranges::copy(rows.is_sliding, replayed.is_sliding.begin() + first);
  std::fill_n(replayed.is_answered.begin() + first, count, 1);
}

Replayed replay(const runtime::AssetView& asset, const Samples& reference, double depth_m,
                const PlayedAs& played_as) {
  Replayed replayed(reference);
  FollowedRows rows = follow(asset, reference, depth_m, played_as);
  replayed.force_N = std::move(rows.force_N);
  replayed.torque_Nm = std::move(rows.torque_Nm);
  replayed.is_sliding = std::move(rows.is_sliding);
  replayed.is_answered.assign(replayed.is_sliding.size(), 1);
  return replayed;
}

void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed) {
  const fit::Bases bases = fit::bases_of(curves);
  const fit::LocalCurves local = fit::curves_at(bases, curves, row, samples, point);
  for (const auto& [experiment, rows] : usable_rows(samples, point)) {
    replayed.force_N(rows, Eigen::all) = fit::local_answer(local, samples, rows).force;
    for (const Eigen::Index i : rows) replayed.is_answered[i] = 1;
  }
}

std::vector<ComparedRow> compare(const Samples& reference, const Points& answer_N,
                                 const std::function<bool(Eigen::Index)>& counts) {
  std::vector<ComparedRow> rows;
  for (Eigen::Index row = 0; row < reference.rows(); ++row)
    if (reference.status[row] == RowStatus::good && counts(row))
      rows.push_back({.reference_N = reference.force.row(row),
                      .engine_N = answer_N.row(row),
                      .reference_error_N = reference.force_error[row],
                      .place = reference.point[static_cast<std::size_t>(row)]});
  return rows;
}

std::vector<ComparedRow> compare(const Samples& reference, const Replayed& replayed) {
  return compare(reference, replayed.force_N,
                 [&](Eigen::Index row) { return replayed.is_answered[row] != 0; });
}

// (M58a)
std::vector<ComparedRow> compare_torques(const Samples& reference, const Replayed& replayed,
                                         double radius_m,
                                         const std::function<bool(Eigen::Index)>& counts) {
  std::vector<ComparedRow> rows;
  for (Eigen::Index row = 0; row < reference.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (reference.status[r] != RowStatus::good || !replayed.is_answered[r] || !counts(row))
      continue;
    const Vec3 to_tip = radius_m * reference.point_normal.row(reference.point[r]);
    const auto moved = [&](const Points& torque_Nm, const Points& force_N) {
      return Vec3(torque_Nm.row(row).transpose() + to_tip.cross(Vec3(force_N.row(row))));
    };
    rows.push_back({reference.force.row(row), replayed.force_N.row(row), reference.force_error[row],
                    moved(reference.torque, reference.force),
                    moved(replayed.torque_Nm, replayed.force_N), reference.point[r]});
  }
  return rows;
}

double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as) {
  Follower follower(asset);
  std::vector<PlayedTool> tools;  // made once, as a simulator does
  for (Eigen::Index row = 0; played_as && row < paths.rows(); ++row)
    tools.push_back(played_as(row));
  const PlayedAs made = [&](Eigen::Index row) { return tools[static_cast<std::size_t>(row)]; };
  const auto play = [&] {
    return follower.follow(paths, depth_m, played_as ? made : nullptr).ticks;
  };
  play();  // tables are made when tools are made
  return tick_ns(play);
}

}  // namespace palpate::validation
