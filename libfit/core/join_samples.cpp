#include "libfit/core/join_samples.hpp"

#include <algorithm>
#include <numeric>

namespace palpate {
namespace {

template <class T>
Eigen::Index size_of(const std::vector<T>& column) {
  return static_cast<Eigen::Index>(column.size());
}
template <class Derived>
Eigen::Index size_of(const Eigen::MatrixBase<Derived>& column) {
  return column.rows();
}
template <class T>
void resize(std::vector<T>& column, Eigen::Index size, const T& fill) {
  column.resize(static_cast<std::size_t>(size), fill);
}
template <class Derived, class T>
void resize(Eigen::PlainObjectBase<Derived>& column, Eigen::Index size, const T& fill) {
  const Eigen::Index before = column.rows();
  column.conservativeResize(size, column.cols());
  if (size > before) column.bottomRows(size - before).setConstant(fill);
}
template <class T>
void copy(const std::vector<T>& from, Eigen::Index row, std::vector<T>& to, Eigen::Index at) {
  to[static_cast<std::size_t>(at)] = from[static_cast<std::size_t>(row)];
}
template <class A, class B>
void copy(const Eigen::MatrixBase<A>& from, Eigen::Index row, Eigen::MatrixBase<B>& to,
          Eigen::Index at) {
  to.row(at) = from.row(row);
}

// Appends places or rows of one column to another; what either lacks is filled.
class Append {
 public:
  Append(const std::vector<Eigen::Index>& which, Eigen::Index before)
      : which_(which), before_(before), after_(before + size_of(which)) {}

  template <class Column>
  void operator()(Column& to, const Column& from) const {
    take(to, from, typename Column::value_type{});
  }
  template <class Column, class T>
  void operator()(Column& to, const Column& from, const T& fill) const {
    const bool has = size_of(to) > 0 && before_ > 0, gets = size_of(from) > 0 && !which_.empty();
    if (!has && !gets) return;
    if (!has) resize(to, before_, fill);
    if (gets)
      take(to, from, fill);
    else
      resize(to, after_, fill);
  }

 private:
  template <class Column, class T>
  void take(Column& to, const Column& from, const T& fill) const {
    resize(to, after_, fill);
    for (std::size_t i = 0; i < which_.size(); ++i)
      copy(from, which_[i], to, before_ + static_cast<Eigen::Index>(i));
  }

  const std::vector<Eigen::Index>& which_;
  Eigen::Index before_, after_;
};

// Of which the surface's motion is not known leave none to the others.
void append_surface(Samples& to, const Samples& from, const std::vector<Eigen::Index>& which) {
  const auto lacks = [](const Samples& s, bool any) { return any && s.surface.cols() == 0; };
  const Eigen::Index before = to.rows(), after = before + size_of(which);
  if (lacks(to, before > 0) || lacks(from, !which.empty())) return to.surface.resize(0, 0);
  if (which.empty()) return;
  to.surface.conservativeResize(after, from.surface.cols());
  for (std::size_t i = 0; i < which.size(); ++i)
    to.surface.row(before + static_cast<Eigen::Index>(i)) = from.surface.row(which[i]);
}

std::vector<Eigen::Index> all_of(Eigen::Index count) {
  std::vector<Eigen::Index> out(static_cast<std::size_t>(count));
  std::iota(out.begin(), out.end(), Eigen::Index{0});
  return out;
}

}  // namespace

void append_points(Samples& to, const Samples& from, const std::vector<Eigen::Index>& which) {
  each_point_column(to, from, Append(which, to.points()));
}

void append_rows(Samples& to, const Samples& from, const std::vector<Eigen::Index>& which) {
  append_surface(to, from, which);
  each_row_column(to, from, Append(which, to.rows()));
}

Samples joined(const Samples& first, const Samples& second) {
  Samples out = first;
  const auto places = static_cast<std::int32_t>(second.points() > 0 ? first.points() : 0);
  const std::int32_t numbers =
      first.experiment.empty() ? 0 : 1 + *std::ranges::max_element(first.experiment);
  const auto before = static_cast<std::size_t>(first.rows());
  append_points(out, second, all_of(second.points()));
  append_rows(out, second, all_of(second.rows()));
  for (std::size_t row = before; row < out.point.size(); ++row) {
    out.point[row] += places;
    out.experiment[row] += numbers;
  }
  return out;
}

Samples row_range(const Samples& samples, Eigen::Index first, Eigen::Index count) {
  std::vector<Eigen::Index> rows = all_of(count);
  for (Eigen::Index& row : rows) row += first;
  Samples out;
  append_points(out, samples, all_of(samples.points()));
  append_rows(out, samples, rows);
  return out;
}

void leave_out_what_says_nothing(Samples& samples) {
  if (!samples.time_s.array().isFinite().any()) samples.time_s.resize(0);
  if (samples.lean.isZero(0)) samples.lean.resize(0, 2);
  if (std::ranges::count(samples.tool, 0) == samples.rows()) samples.tool.clear();
  if (std::ranges::count(samples.probe_number, 0) == samples.rows()) samples.probe_number.clear();
}

Samples of_kinds(const Samples& samples, std::initializer_list<ExperimentKind> kinds) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (std::ranges::find(kinds, samples.kind[static_cast<std::size_t>(row)]) != kinds.end())
      rows.push_back(row);
  return rows_of(samples, rows);
}

Samples rows_of(const Samples& samples, const std::vector<Eigen::Index>& rows) {
  std::vector<Eigen::Index> points;
  std::vector<std::int32_t> number(static_cast<std::size_t>(samples.points()), -1);
  for (const Eigen::Index row : rows)
    number[static_cast<std::size_t>(samples.point[static_cast<std::size_t>(row)])] = 0;
  for (std::size_t p = 0; p < number.size(); ++p)
    if (number[p] == 0) {
      number[p] = static_cast<std::int32_t>(points.size());
      points.push_back(static_cast<Eigen::Index>(p));
    }
  Samples out;
  append_points(out, samples, points);
  append_rows(out, samples, rows);
  for (std::int32_t& p : out.point) p = number[static_cast<std::size_t>(p)];
  leave_out_what_says_nothing(out);
  static_cast<SampleOrigin&>(out) = samples;
  return out;
}

}  // namespace palpate
