#pragma once

#include <array>
#include <string>
#include <vector>

#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// Reference rows with their answers.
struct Rows {
  Samples reference;
  std::vector<Vec3> answer_N;

  Rows(std::initializer_list<std::array<double, 2>> rows = {}) {
    for (const auto& [reference_N, error_N] : rows) add(reference_N, error_N);
  }
  void add(double reference_N, double error_N, std::int32_t place = 0) {
    const Eigen::Index row = reference.rows();
    reference.point.push_back(place);
    reference.status.push_back(RowStatus::good);
    reference.deflection.setZero(row + 1, 3);
    reference.force.conservativeResize(row + 1, 3);
    reference.force.row(row) << 0, 0, reference_N;
    reference.force_error.conservativeResize(row + 1);
    reference.force_error[row] = 0.01 * reference_N;
    answer_N.emplace_back(0, 0, reference_N + error_N);
  }
  Replayed answer() const {
    Replayed out(reference);
    for (std::size_t i = 0; i < answer_N.size(); ++i) out.force_N.row(i) = answer_N[i];
    out.is_answered.assign(answer_N.size(), 1);
    return out;
  }
};

inline Statement summarize(const Rows& rows) {
  return validation::summarize(compare(rows.reference, rows.answer()));
}

/// A line of rows of a body whose floor is 0.04 N, or of a softer one.
inline StatedError line(std::string name, const Rows& rows, double floor_N = 0.04) {
  return stated_error(std::move(name), compare(rows.reference, rows.answer()), {floor_N});
}

}  // namespace palpate::validation
