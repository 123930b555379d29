#include "libfit/validation/replay.hpp"

#include <algorithm>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/fit/point/replay.hpp"

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

constexpr double kSamePlace = 1e-6;  // of what the points span

bool is_good_press(const Samples& samples, Eigen::Index row) {
  return samples.kind[row] == ExperimentKind::press && samples.status[row] == RowStatus::good;
}

double along(const Points& vectors, Eigen::Index row, const Samples& samples) {
  return vectors.row(row).dot(samples.point_normal.row(samples.point[row]));
}

double mean_push_N(const std::vector<PressTable>& presses, double depth_m) {
  double sum_N = 0;
  for (const PressTable& press : presses) sum_N += press.at(depth_m);
  return sum_N / static_cast<double>(presses.size());
}

void answer(const Samples& asked, Eigen::Index row, double push_N, Replayed& replayed) {
  replayed.force_N.row(row) = push_N * asked.point_normal.row(asked.point[row]);
  replayed.is_answered[row] = 1;
}

}  // namespace

void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed) {
  const fit::Bases bases = fit::bases_of(curves);
  const fit::LocalCurves local = fit::curves_at(bases, curves, row, samples, point);
  for (const auto& [experiment, rows] : usable_rows(samples, point)) {
    replayed.force_N(rows, Eigen::all) = fit::local_answer(local, samples, rows).force;
    for (const Eigen::Index i : rows) replayed.is_answered[i] = 1;
  }
}

double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as) {
  Follower follower(asset);
  std::vector<PlayedTool> tools;  // made once, as a simulator does
  for (Eigen::Index row = 0; played_as && row < paths.rows(); ++row)
    tools.push_back(played_as(row));
  const PlayedAs made = [&](Eigen::Index row) { return tools[row]; };
  const auto play = [&] {
    return follower.follow(paths, depth_m, played_as ? made : nullptr).ticks;
  };
  play();  // tables are made when tools are made
  return tick_ns(play);
}

double PressTable::at(double depth) const {
  const auto after = std::upper_bound(depth_m.begin() + 1, depth_m.end(), depth);
  const auto i =
      std::min<std::size_t>(static_cast<std::size_t>(after - depth_m.begin()), depth_m.size() - 1);
  const double share = (depth - depth_m[i - 1]) / (depth_m[i] - depth_m[i - 1]);
  return push_N[i - 1] + share * (push_N[i] - push_N[i - 1]);
}

std::map<std::int32_t, std::vector<PressTable>> presses_of(const Samples& samples) {
  std::map<std::int32_t, std::map<std::int32_t, PressTable>> found;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    if (!is_good_press(samples, row)) continue;
    PressTable& press = found[samples.point[row]][samples.experiment[row]];
    const double depth_m = along(samples.deflection, row, samples);
    if (!(depth_m > press.depth_m.back())) continue;
    press.depth_m.push_back(depth_m);
    press.push_N.push_back(along(samples.force, row, samples));
  }
  std::map<std::int32_t, std::vector<PressTable>> out;
  for (auto& [point, experiments] : found)
    for (auto& [experiment, press] : experiments)
      if (press.depth_m.size() > 1) out[point].push_back(std::move(press));
  return out;
}

Replayed neighbouring_presses(const Samples& fitted, const Samples& asked, int neighbours) {
  Replayed out(asked);
  const auto presses = presses_of(fitted);
  const double same_m =
      fitted.points() > 0 ? kSamePlace * extent_m(fitted.point_position).norm() : 0;
  std::vector<std::vector<std::pair<double, std::int32_t>>> near(
      static_cast<std::size_t>(asked.points()));
  for (std::size_t p = 0; p < near.size(); ++p) {
    const auto at = asked.point_position.row(p);
    for (const auto& [point, tables] : presses)
      if (const double away_m = (fitted.point_position.row(point) - at).norm(); away_m > same_m)
        near[p].emplace_back(away_m, point);
    std::ranges::sort(near[p]);
    near[p].resize(std::min(near[p].size(), static_cast<std::size_t>(neighbours)));
  }
  for (Eigen::Index row = 0; row < asked.rows(); ++row) {
    const auto& around = near[asked.point[row]];
    if (!is_good_press(asked, row) || around.empty()) continue;
    const double depth_m = along(asked.deflection, row, asked);
    double sum_N = 0, weights = 0;
    for (const auto& [away_m, point] : around) {
      const double weight = 1 / (away_m * away_m);
      sum_N += weight * mean_push_N(presses.at(point), depth_m);
      weights += weight;
    }
    answer(asked, row, sum_N / weights, out);
  }
  return out;
}

Replayed neighbouring_rows(const Samples& fitted, const Samples& asked, int neighbours) {
  struct PassRow {
    Eigen::Index row;
    Vec3 place, motion;
  };
  const auto states = [](const Samples& s) {
    std::vector<PassRow> out;
    for (Eigen::Index row = 0; row + 1 < s.rows(); ++row) {
      if (s.kind[row] != ExperimentKind::scan || s.status[row] != RowStatus::good) continue;
      const bool is_last = s.experiment[row + 1] != s.experiment[row];
      const Eigen::Index from = is_last ? row - 1 : row;
      if (from < 0 || s.experiment[from] != s.experiment[row]) continue;
      const Vec3 place = s.point_position.row(s.point[row]) + s.deflection.row(row),
                 step = s.deflection.row(from + 1) - s.deflection.row(from);
      out.push_back({row, place, 0.05 / (s.time_of(from + 1) - s.time_of(from)) * step});
    }
    return out;
  };
  Replayed out(asked);
  const auto known = states(fitted);
  if (std::ssize(known) < neighbours) return out;
  std::vector<std::pair<double, Eigen::Index>> near(known.size());
  for (const auto& [row, place, motion] : states(asked)) {
    for (std::size_t i = 0; i < known.size(); ++i)
      near[i] = {(known[i].place - place).squaredNorm() + (known[i].motion - motion).squaredNorm(),
                 known[i].row};
    std::ranges::nth_element(near, near.begin() + neighbours - 1);
    for (int i = 0; i < neighbours; ++i)
      out.force_N.row(row) += fitted.force.row(near[i].second) / neighbours;
    out.is_answered[row] = 1;
  }
  return out;
}

Replayed left_out_presses(const FittedCurves& curves, const InterpolationChoice& found,
                          const Samples& asked) {
  Replayed out(asked);
  if (found.left_out.empty()) return out;
  const Points known = curves.position(found.left_out, Eigen::all);
  CurveSet rows(curves.curves.family);
  rows.basis = curves.curves.basis;
  rows.control[0] = found.left_out_normal;
  const NodeForces forces(rows);
  const double same_m = kSamePlace * extent_m(curves.position).norm();
  for (Eigen::Index row = 0; row < asked.rows(); ++row) {
    if (!is_good_press(asked, row)) continue;
    Eigen::Index nearest = 0;
    const auto at = asked.point_position.row(asked.point[row]);
    const double away_m = (known.rowwise() - at).rowwise().norm().minCoeff(&nearest);
    if (away_m <= same_m)
      answer(asked, row, forces.normal_N(nearest, along(asked.deflection, row, asked)), out);
  }
  return out;
}

PlacedPoints placed_points(const runtime::AssetView& asset, const Samples& samples) {
  const Surface surface = surface_of(asset);
  const BoxTree boxes = triangle_boxes(surface);
  PlacedPoints out{samples.point_position, Eigen::VectorXd::Zero(samples.points()),
                   std::vector<char>(static_cast<std::size_t>(samples.points()), 0)};
  for (Eigen::Index p = 0; p < samples.points(); ++p) {
    const auto hit = closest_point(surface, boxes, samples.point_position.row(p));
    if (!hit) continue;
    out.position.row(p) = hit->position.transpose();
    out.distance_m[p] = hit->distance_m;
    bool is_covered = true;
    for (int k = 0; k < 3; ++k)
      is_covered &= hit->weight[k] <= kSamePlace ||
                    asset.covered[surface.triangles(hit->triangle, k)] == runtime::kMeasured;
    out.is_covered[p] = is_covered;
  }
  return out;
}

}  // namespace palpate::validation
