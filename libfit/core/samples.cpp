#include "libfit/core/samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate {
namespace {

template <class Column>
Eigen::Index size_of(const Column& column) {
  if constexpr (requires { column.rows(); })
    return column.rows();
  else
    return std::ssize(column);
}
template <class T>
void resize(std::vector<T>& column, Eigen::Index size, const T& fill) {
  column.resize(size, fill);
}
template <class Derived, class T>
void resize(Eigen::PlainObjectBase<Derived>& column, Eigen::Index size, const T& fill) {
  const Eigen::Index before = column.rows();
  column.conservativeResize(size, column.cols());
  if (size > before) column.bottomRows(size - before).setConstant(fill);
}
template <class T>
void copy(const std::vector<T>& from, Eigen::Index row, std::vector<T>& to, Eigen::Index at) {
  to[at] = from[row];
}
template <class A, class B>
void copy(const Eigen::MatrixBase<A>& from, Eigen::Index row, Eigen::MatrixBase<B>& to,
          Eigen::Index at) {
  to.row(at) = from.row(row);
}
template <class T>
bool is_void(const std::vector<T>& column, const T& fill) {
  return std::ranges::count(column, fill) == std::ssize(column);
}
template <class Derived>
bool is_void(const Eigen::MatrixBase<Derived>& column, double fill) {
  return std::isnan(fill) ? column.array().isNaN().all() : (column.array() == fill).all();
}

// Copies entries of one column into another from row `at` on, which is made `total` rows long;
// entries that either lacks are filled.
struct Copy {
  const std::vector<Eigen::Index>& which;
  Eigen::Index at, total;

  template <class Column>
  void operator()(Column& to, const Column& from) const {
    take(to, from, typename Column::value_type{});
  }
  template <class Column, class T>
  void operator()(Column& to, const Column& from, const T& fill) const {
    const bool gets = size_of(from) > 0 && !which.empty();
    if (gets || (size_of(to) > 0 && at > 0)) resize(to, total, fill);
    if (gets) take(to, from, fill);
  }

 private:
  template <class Column, class T>
  void take(Column& to, const Column& from, const T& fill) const {
    resize(to, total, fill);
    for (Eigen::Index i = 0; i < std::ssize(which); ++i) copy(from, which[i], to, at + i);
  }
};

void copy_rows(SampleRows& to, const SampleRows& from, const Copy& copy_column) {
  each_row_column([&](auto, auto column, auto&&, auto... fill) {
    copy_column(to.*column, from.*column, fill...);
  });
}

bool lacks_surface(const SampleRows& rows, bool has_rows) {
  return has_rows && rows.surface.cols() == 0;
}

std::vector<Eigen::Index> all_of(Eigen::Index count, Eigen::Index first = 0) {
  std::vector<Eigen::Index> out(count);
  std::iota(out.begin(), out.end(), first);
  return out;
}

using RowNumbers = std::vector<Eigen::Index>;

std::map<std::int32_t, RowNumbers> rows_of_presses(const Samples& samples) {
  std::map<std::int32_t, RowNumbers> out;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const ExperimentKind kind = samples.kind[i];
    if (kind == ExperimentKind::press || kind == ExperimentKind::cycle)
      out[samples.experiment[i]].push_back(i);
  }
  for (auto& [number, rows] : out)
    std::ranges::stable_sort(rows, {}, [&](Eigen::Index i) { return samples.step[i]; });
  return out;
}

Vec3 inward_at(const Samples& samples, Eigen::Index row) {
  return samples.point_normal.row(samples.point[row]);
}

Vec3 lateral(const Vec3& vector, const Vec3& inward) {
  return vector - vector.dot(inward) * inward;
}

// Farthest that the mean of a quarter of the rows, which is a place and no noise, lies beside the
// normal.
double sideways_m(const std::vector<Vec3>& aside) {
  const std::size_t window = std::max<std::size_t>(2, aside.size() / 4);
  double most = 0;
  for (std::size_t first = 0; first + window <= aside.size(); ++first) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < window; ++k) sum += aside[first + k];
    most = std::max(most, sum.norm() / static_cast<double>(window));
  }
  return most;
}

// True if force goes along lateral motion, by more than four errors of what scatters about that.
bool is_friction_seen(const std::vector<Vec3>& aside, const std::vector<Vec3>& force) {
  double squares = 0, along = 0, left = 0;
  for (std::size_t i = 0; i < aside.size(); ++i)
    squares += aside[i].squaredNorm(), along += force[i].dot(aside[i]);
  const double stiffness = along / squares;
  for (std::size_t i = 0; i < aside.size(); ++i)
    left += (force[i] - stiffness * aside[i]).squaredNorm();
  const double variance = left / static_cast<double>(2 * aside.size() - 1);
  return stiffness > 4 * std::sqrt(variance / squares);
}

bool is_usable(const Samples& samples, Eigen::Index row) {
  return samples.status[row] == RowStatus::good && samples.deflection.row(row).allFinite() &&
         samples.force.row(row).allFinite();
}

bool is_on_purpose(const Samples& samples, const RowNumbers& rows) {
  std::vector<Vec3> aside, force;
  double deepest_m = 0;
  for (const Eigen::Index i : rows) {
    if (!is_usable(samples, i)) continue;
    const Vec3 inward = inward_at(samples, i), deflection = samples.deflection.row(i);
    deepest_m = std::max(deepest_m, deflection.dot(inward));
    aside.push_back(lateral(deflection, inward));
    force.push_back(lateral(samples.force.row(i), inward));
  }
  // The tangent of 20 degrees: rigs and normals of surfaces are off by a few degrees, and a tool
  // that slides on purpose goes farther.
  return aside.size() > 2 && sideways_m(aside) > 0.36 * deepest_m && is_friction_seen(aside, force);
}

bool is_crooked(const Samples& samples, const RowNumbers& rows) {
  double deepest_m = 0, most_m = 0;
  for (const Eigen::Index i : rows) {
    const Vec3 inward = inward_at(samples, i), deflection = samples.deflection.row(i);
    if (!deflection.allFinite()) continue;
    deepest_m = std::max(deepest_m, deflection.dot(inward));
    most_m = std::max(most_m, lateral(deflection, inward).norm());
  }
  return deepest_m > 0 && most_m > 1e-6 * deepest_m;
}

}  // namespace

void append_points(SamplePlaces& to, const SamplePlaces& from,
                   const std::vector<Eigen::Index>& which) {
  const Copy copy{which, to.points(), to.points() + size_of(which)};
  each_point_column(
      [&](auto, auto column, auto&&, auto... fill) { copy(to.*column, from.*column, fill...); });
}

void append_rows(SampleRows& to, const SampleRows& from, const std::vector<Eigen::Index>& which) {
  const Eigen::Index before = to.rows(), after = before + size_of(which);
  if (before == 0) to.surface.resize(0, from.surface.cols());
  if (lacks_surface(to, before > 0) || lacks_surface(from, !which.empty()))
    to.surface.resize(0, 0);
  else if (!which.empty())
    Copy{which, before, after}(to.surface, from.surface, 0.0F);
  copy_rows(to, from, {which, before, after});
}

SampleRows joined_rows(const std::vector<const SampleRows*>& parts) {
  SampleRows out;
  Eigen::Index total = 0, at = 0;
  for (const SampleRows* part : parts) total += part->rows();
  for (const SampleRows* part : parts) {
    copy_rows(out, *part, {all_of(part->rows()), at, total});
    at += part->rows();
  }
  return out;
}

Samples joined(const Samples& first, const Samples& second) {
  Samples out = first;
  const Eigen::Index places = second.points() > 0 ? first.points() : 0, before = first.rows();
  const std::int32_t numbers =
      first.experiment.empty() ? 0 : 1 + *std::ranges::max_element(first.experiment);
  append_points(out, second, all_of(second.points()));
  append_rows(out, second, all_of(second.rows()));
  for (Eigen::Index row = before; row < out.rows(); ++row) {
    out.point[row] += static_cast<std::int32_t>(places);
    out.experiment[row] += numbers;
  }
  return out;
}

Samples row_range(const Samples& samples, Eigen::Index first, Eigen::Index count) {
  Samples out;
  append_points(out, samples, all_of(samples.points()));
  append_rows(out, samples, all_of(count, first));
  return out;
}

void remove_void_columns(SampleRows& rows) {
  each_row_column([&](auto, auto column, auto&&, auto... fill) {
    // That all checks passed is told by a column of checks.
    if constexpr (sizeof...(fill) > 0 &&
                  !std::is_same_v<decltype(column), decltype(&SampleRows::step_check)>)
      if (is_void(rows.*column, fill...)) rows.*column = {};
  });
}

Samples rows_where(const Samples& samples, const std::function<bool(Eigen::Index)>& is_wanted) {
  std::vector<Eigen::Index> rows, points;
  std::vector<std::int32_t> number(samples.points(), -1);
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (is_wanted(row)) rows.push_back(row), number[samples.point[row]] = 0;
  for (Eigen::Index p = 0; p < samples.points(); ++p)
    if (number[p] == 0) {
      number[p] = static_cast<std::int32_t>(points.size());
      points.push_back(p);
    }
  Samples out;
  append_points(out, samples, points);
  append_rows(out, samples, rows);
  for (std::int32_t& p : out.point) p = number[p];
  remove_void_columns(out);
  static_cast<SampleOrigin&>(out) = samples;
  return out;
}

Samples of_kinds(const Samples& samples, std::initializer_list<ExperimentKind> kinds) {
  return rows_where(samples, [&](Eigen::Index row) {
    return std::ranges::find(kinds, samples.kind[row]) != kinds.end();
  });
}

Samples rows_at(const Samples& samples, const std::vector<char>& is_marked, bool wanted) {
  return rows_where(
      samples, [&](Eigen::Index row) { return (is_marked[samples.point[row]] != 0) == wanted; });
}

std::vector<std::int32_t> straighten_presses(Samples& samples) {
  std::vector<std::int32_t> on_purpose;
  for (const auto& [number, rows] : rows_of_presses(samples)) {
    if (!is_crooked(samples, rows)) continue;
    if (is_on_purpose(samples, rows)) {
      on_purpose.push_back(number);
      continue;
    }
    for (const Eigen::Index i : rows) {
      const Vec3 inward = inward_at(samples, i);
      samples.deflection.row(i) = samples.deflection.row(i).dot(inward) * inward;
      samples.force.row(i) = samples.force.row(i).dot(inward) * inward;
    }
  }
  return on_purpose;
}

bool has_crooked_press(const Samples& samples) {
  return std::ranges::any_of(rows_of_presses(samples), [&](const auto& press) {
    return is_crooked(samples, press.second) && !is_on_purpose(samples, press.second);
  });
}

std::map<std::int32_t, double> contact_deviations_m(const MeasuredRecordings& recordings) {
  std::map<std::int32_t, std::pair<double, int>> sums;  // of squares, count
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const double deviation_m = recordings.contact_deviation_m[r];
    if (!(deviation_m > 0) || !std::isfinite(deviation_m)) continue;
    auto& [squares, count] = sums[recordings.experiment[r]];
    squares += deviation_m * deviation_m, ++count;
  }
  std::map<std::int32_t, double> out;
  for (const auto& [experiment, of] : sums) out[experiment] = std::sqrt(of.first) / of.second;
  return out;
}

}  // namespace palpate
