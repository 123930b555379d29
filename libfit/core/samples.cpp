#include "libfit/core/samples.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

namespace palpate {
namespace {

// Place and normal of a point, and what is done there: -1 where it does not matter.
using Key = std::array<double, 8>;

Key key_of(const Points& position, const Points& normal, Eigen::Index point,
           const std::optional<Effort>& effort) {
  return {position(point, 0),
          position(point, 1),
          position(point, 2),
          normal(point, 0),
          normal(point, 1),
          normal(point, 2),
          effort ? effort->is_dragged : -1.0,
          effort ? effort->scale : -1.0};
}

std::vector<Key> keys_of(const TestPoints& points, const std::vector<Effort>& effort) {
  std::vector<Key> keys;
  for (Eigen::Index p = 0; p < points.position.rows(); ++p)
    keys.push_back(
        key_of(points.position, points.normal, p,
               effort.empty() ? std::nullopt : std::optional(effort[static_cast<std::size_t>(p)])));
  return keys;
}
std::vector<Key> keys_of(const Samples& samples, bool effort_matters) {
  std::vector<Effort> effort(static_cast<std::size_t>(samples.points()));
  for (std::size_t row = 0; row < samples.point.size(); ++row)
    if (samples.kind[row] == ExperimentKind::drag)
      effort[static_cast<std::size_t>(samples.point[row])].is_dragged = true;
  for (Eigen::Index p = 0; p < samples.point_scale.size(); ++p)
    effort[static_cast<std::size_t>(p)].scale = samples.point_scale[p];
  std::vector<Key> keys;
  for (Eigen::Index p = 0; p < samples.points(); ++p)
    keys.push_back(
        key_of(samples.point_position, samples.point_normal, p,
               effort_matters ? std::optional(effort[static_cast<std::size_t>(p)]) : std::nullopt));
  return keys;
}

// Appends a row under the number of another point.
void append_row(Samples& to, const Samples& from, Eigen::Index row, std::int32_t point,
                int per_point) {
  const auto r = static_cast<std::size_t>(row);
  const auto at = static_cast<Eigen::Index>(to.point.size());
  to.point.push_back(point);
  to.experiment.push_back(from.experiment[r] + per_point * (point - from.point[r]));
  to.kind.push_back(from.kind[r]);
  to.step.push_back(from.step[r]);
  to.status.push_back(from.status[r]);
  to.step_check.push_back(from.step_check.empty() ? StepCheck::none : from.step_check[r]);
  to.deflection.row(at) = from.deflection.row(row);
  to.force.row(at) = from.force.row(row);
  to.torque.row(at) = from.torque.row(row);
  to.force_error[at] = from.force_error[row];
  if (to.time_s.size() > 0) to.time_s[at] = from.time_s[row];
  if (to.lean.rows() > 0) to.lean.row(at) = from.lean.row(row);
  if (to.surface.cols() > 0) to.surface.row(at) = from.surface.row(row);
}

void resize_rows(Samples& samples, Eigen::Index rows, Eigen::Index surface_columns, bool has_time,
                 bool leans) {
  samples.time_s.conservativeResize(has_time ? rows : 0);
  samples.lean.conservativeResize(leans ? rows : 0, 2);
  samples.surface.conservativeResize(surface_columns > 0 ? rows : 0, surface_columns);
  samples.deflection.conservativeResize(rows, 3);
  samples.force.conservativeResize(rows, 3);
  samples.torque.conservativeResize(rows, 3);
  samples.force_error.conservativeResize(rows);
}

}  // namespace

Samples take_points(const Samples& from, const TestPoints& wanted, int per_point,
                    const std::vector<Effort>& effort) {
  std::map<Key, std::int32_t> index;
  std::int32_t number = 0;
  for (const Key& key : keys_of(wanted, effort)) index.emplace(key, number++);
  const std::vector<Key> keys = keys_of(from, !effort.empty());
  const std::vector<std::int32_t> empty = points_without_rows(from);
  std::vector<char> is_taken(static_cast<std::size_t>(wanted.position.rows()), 0);
  std::vector<std::int32_t> new_number;
  for (Eigen::Index p = 0; p < from.points(); ++p) {
    const auto found = index.find(keys[static_cast<std::size_t>(p)]);
    const bool is_wanted = found != index.end() &&
                           !std::binary_search(empty.begin(), empty.end(), p) &&
                           !is_taken[static_cast<std::size_t>(found->second)];
    new_number.push_back(is_wanted ? found->second : -1);
    if (is_wanted) is_taken[static_cast<std::size_t>(found->second)] = 1;
  }
  // Rows by wanted point, each point's in their order.
  std::vector<std::vector<Eigen::Index>> rows_of(static_cast<std::size_t>(wanted.position.rows()));
  Eigen::Index rows = 0;
  for (Eigen::Index row = 0; row < from.rows(); ++row) {
    const auto point = static_cast<std::size_t>(from.point[static_cast<std::size_t>(row)]);
    if (new_number[point] < 0) continue;
    rows_of[static_cast<std::size_t>(new_number[point])].push_back(row);
    ++rows;
  }
  Samples out;
  out.point_position = wanted.position;
  out.point_normal = wanted.normal;
  out.point_name = wanted.name;
  out.point_normal_gradient.setZero(wanted.position.rows(), 9);
  resize_rows(out, rows, from.surface.cols(), from.time_s.size() > 0, from.lean.rows() > 0);
  out.relaxation = from.relaxation;
  for (Eigen::Index p = 0; p < from.points(); ++p)
    if (new_number[static_cast<std::size_t>(p)] >= 0 && from.point_normal_gradient.rows() != 0)
      out.point_normal_gradient.row(new_number[static_cast<std::size_t>(p)]) =
          from.point_normal_gradient.row(p);
  if (from.point_sway.rows() > 0) {
    out.point_sway.setZero(wanted.position.rows(), 6);
    for (Eigen::Index p = 0; p < from.points(); ++p)
      if (new_number[static_cast<std::size_t>(p)] >= 0)
        out.point_sway.row(new_number[static_cast<std::size_t>(p)]) = from.point_sway.row(p);
  }
  out.point_scale.setZero(wanted.position.rows());
  for (Eigen::Index p = 0; p < from.point_scale.size(); ++p)
    if (new_number[static_cast<std::size_t>(p)] >= 0)
      out.point_scale[new_number[static_cast<std::size_t>(p)]] = from.point_scale[p];
  for (std::size_t p = 0; p < rows_of.size(); ++p)
    for (const Eigen::Index row : rows_of[p])
      append_row(out, from, row, static_cast<std::int32_t>(p), per_point);
  return out;
}

Samples joined(const Samples& first, const Samples& second, int per_point) {
  Samples out = first;
  const Eigen::Index before = first.points(), points = before + second.points();
  out.point_position.conservativeResize(points, 3);
  out.point_normal.conservativeResize(points, 3);
  out.point_normal_gradient.conservativeResize(points, 9);
  out.point_position.bottomRows(second.points()) = second.point_position;
  out.point_normal.bottomRows(second.points()) = second.point_normal;
  out.point_normal_gradient.bottomRows(second.points()) = second.point_normal_gradient;
  const bool is_still =
      first.point_sway.rows() < before || second.point_sway.rows() < second.points();
  out.point_sway.conservativeResize(is_still ? 0 : points, 6);
  if (!is_still) out.point_sway.bottomRows(second.points()) = second.point_sway;
  out.point_scale.setZero(points);
  out.point_scale.head(first.point_scale.size()) = first.point_scale;
  out.point_scale.segment(before, second.point_scale.size()) = second.point_scale;
  out.point_name.insert(out.point_name.end(), second.point_name.begin(), second.point_name.end());
  // Rows of which the surface's motion is not known leave none to the others.
  const auto lacks = [](const Samples& s) { return s.rows() > 0 && s.surface.cols() == 0; };
  resize_rows(
      out, first.rows() + second.rows(),
      lacks(first) || lacks(second) ? 0 : std::max(first.surface.cols(), second.surface.cols()),
      first.time_s.size() > 0 && second.time_s.size() > 0,
      first.lean.rows() > 0 && second.lean.rows() > 0);
  out.step_check.resize(out.point.size(), StepCheck::none);  // where nothing was checked in `first`
  for (Eigen::Index row = 0; row < second.rows(); ++row)
    append_row(out, second, row,
               static_cast<std::int32_t>(before) + second.point[static_cast<std::size_t>(row)],
               per_point);
  return out;
}

std::vector<std::int32_t> points_without_rows(const Samples& samples) {
  std::vector<char> has_rows(static_cast<std::size_t>(samples.points()), 0);
  for (const std::int32_t point : samples.point) has_rows[static_cast<std::size_t>(point)] = 1;
  std::vector<std::int32_t> without;
  for (std::size_t p = 0; p < has_rows.size(); ++p)
    if (!has_rows[p]) without.push_back(static_cast<std::int32_t>(p));
  return without;
}

Samples samples_beyond(const Samples& samples, const TestPoints& points, int per_point,
                       const std::vector<Effort>& effort) {
  const std::vector<Key> wanted = keys_of(points, effort), keys = keys_of(samples, !effort.empty());
  std::set<Key> known(wanted.begin(), wanted.end());
  const std::vector<std::int32_t> empty = points_without_rows(samples);
  std::vector<Eigen::Index> beyond;
  std::vector<Effort> done;
  for (Eigen::Index p = 0; p < samples.points(); ++p) {
    const Key& key = keys[static_cast<std::size_t>(p)];
    if (std::binary_search(empty.begin(), empty.end(), p) || !known.insert(key).second) continue;
    beyond.push_back(p);
    done.push_back({key[6] > 0, key[7]});
  }
  TestPoints out;
  out.triangles.resize(0, 3);
  out.position = samples.point_position(beyond, Eigen::all);
  out.normal = samples.point_normal(beyond, Eigen::all);
  for (const Eigen::Index p : beyond)
    out.name.push_back(samples.point_name[static_cast<std::size_t>(p)]);
  return take_points(samples, out, per_point, effort.empty() ? effort : done);
}

}  // namespace palpate
