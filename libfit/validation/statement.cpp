#include "libfit/validation/statement.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::validation {
namespace {

ErrorFigures figures(const std::vector<double>& size, const std::vector<double>& error,
                     const std::vector<double>& relative) {
  return {stated_quantile(size, 0.5),     stated_quantile(error, 0.5),
          stated_quantile(error, 0.95),   stated_quantile(error, 1),
          stated_quantile(relative, 0.5), stated_quantile(relative, 0.95),
          stated_quantile(relative, 1)};
}

// (M11a)
ErrorFigures force_figures(const std::vector<ComparedRow>& rows, double floor_N) {
  std::vector<double> size, error, relative;
  for (const ComparedRow& row : rows) {
    size.push_back(row.reference_N.norm());
    error.push_back((row.engine_N - row.reference_N).norm());
    if (size.back() > floor_N)
      relative.push_back(relative_error(error.back(), size.back(), floor_N));
  }
  return figures(size, error, relative);
}

// (M58a)
ErrorFigures torque_figures(const std::vector<ComparedRow>& rows, double floor_Nm) {
  std::vector<double> size, error, relative;
  for (const ComparedRow& row : rows) {
    if (row.reference_Nm.hasNaN() || row.engine_Nm.hasNaN()) continue;
    size.push_back(row.reference_Nm.norm());
    error.push_back((row.engine_Nm - row.reference_Nm).norm());
    if (floor_Nm > 0) relative.push_back(relative_error(error.back(), size.back(), floor_Nm));
  }
  return figures(size, error, relative);
}

double share(std::size_t of, std::size_t all) {
  return all == 0 ? kNoNumber : static_cast<double>(of) / static_cast<double>(all);
}

}  // namespace

const std::vector<StatedError>& Statement::lines_of(std::string_view section) const {
  static const std::vector<StatedError> kNone;
  const auto found = std::ranges::find(sections, section, &StatementSection::name);
  return found == sections.end() ? kNone : found->lines;
}

ErrorFloors floors_of(const std::vector<ComparedRow>& rows) {
  double largest_N = 0, largest_Nm = 0;
  for (const ComparedRow& row : rows) {
    largest_N = std::max(largest_N, row.reference_N.norm());
    if (!row.reference_Nm.hasNaN()) largest_Nm = std::max(largest_Nm, row.reference_Nm.norm());
  }
  return {relative_floor_N(largest_N), relative_floor_Nm(largest_Nm)};
}

StatedError stated_error(std::string name, const std::vector<ComparedRow>& rows,
                         const ErrorFloors& floors) {
  return {std::move(name), rows.size(), force_figures(rows, floors.force_N),
          torque_figures(rows, floors.torque_Nm)};
}

Statement summarize(const std::vector<ComparedRow>& rows) {
  return summarize(rows, floors_of(rows));
}

Statement summarize(const std::vector<ComparedRow>& rows, const ErrorFloors& floors) {
  Statement statement;
  statement.all = stated_error("all", rows, floors);
  statement.floor_N = floors.force_N;
  std::vector<double> reference_rel;
  std::size_t within = 0, within_reference = 0;
  double felt_N = 0;  // most that a hand met, of either
  for (const ComparedRow& row : rows) {
    const double error = (row.engine_N - row.reference_N).norm(), force = row.reference_N.norm();
    felt_N = std::max({felt_N, force, row.engine_N.norm()});
    if (is_within_jnd(error, force)) ++within;
    if (force <= floors.force_N) continue;
    ++statement.rows_above_floor;
    if (!std::isfinite(row.reference_error_N)) continue;
    reference_rel.push_back(relative_error(row.reference_error_N, force, floors.force_N));
    if (error <= row.reference_error_N) ++within_reference;
  }
  statement.reference_p95_rel = stated_quantile(reference_rel, 0.95);
  statement.within_reference = share(within_reference, reference_rel.size());
  if (felt_N > kForceFloor_N) statement.within_jnd = share(within, rows.size());
  return statement;
}

}  // namespace palpate::validation
