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

}  // namespace palpate
