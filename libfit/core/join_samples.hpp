#pragma once

#include <initializer_list>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate {

/// Appends places, or rows, of `from` by their numbers. Columns that either lacks are filled with
/// what each_point_column() and each_row_column() say; where rows of either do not say how the
/// surface moved, none of the result do.
void append_points(Samples& to, const Samples& from, const std::vector<Eigen::Index>& which);
void append_rows(Samples& to, const Samples& from, const std::vector<Eigen::Index>& which);

/// Places and rows of both, those of `first` in front, experiments numbered anew; places of both
/// come twice. Rows of a second without places are at those of the first.
Samples joined(const Samples& first, const Samples& second);

/// Rows from `first` on, at the same places.
Samples row_range(const Samples& samples, Eigen::Index first, Eigen::Index count);

/// Columns of time, force asked for, lean and tool that say nothing go.
void leave_out_what_says_nothing(Samples& samples);

/// The rows of these kinds at their places, which keep their order; columns that then say nothing
/// (no time, one tool, no lean) are left out.
Samples rows_of(const Samples& samples, const std::vector<Eigen::Index>& rows);
Samples of_kinds(const Samples& samples, std::initializer_list<ExperimentKind> kinds);

}  // namespace palpate
