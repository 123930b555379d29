#pragma once

#include <vector>

#include "libfit/validation/statement.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {

/// What a rival did along the held-out paths.
struct Performance {
  validation::Statement statement;               ///< of the rows that it came to
  std::vector<validation::StatedError> by_path;  ///< of each kind of path
  std::size_t paths = 0;                         ///< of them before its time was over
  RestCount rest;                                ///< at the rows of these
  double tick_median_us = 0, tick_p999_us = 0;   ///< of ticks in contact
  double jump_N = validation::kNoNumber;  ///< largest change of force over 10 um of a slide; none
                                          ///< where its time was over before
  double created_share = 0;  ///< most that a closed loop gave back beyond what was put into it, of
                             ///< the most that was in it
};

/// Walks a rival along the held-out paths, each from a tenth of the depth outside and straight out
/// again at its end, which closes the loop, until budget_s of CPU are over (one path at least);
/// then along the second half of the sliding ones in steps of 10 um, with a third of that.
Performance measure(const Rival& rival, const RivalBody& body, double budget_s);

/// Work [J] of the tool on the body along places, by the trapezoidal rule; peak_J: most on the way.
class WorkAccount {
 public:
  void add(const Vec3& place_m, const Vec3& force_N);
  double work_J() const { return work_J_; }
  double peak_J() const { return peak_J_; }

 private:
  bool is_first_ = true;
  Vec3 place_m_ = Vec3::Zero(), force_N_ = Vec3::Zero();
  double work_J_ = 0, peak_J_ = 0;
};

}  // namespace palpate::tools
