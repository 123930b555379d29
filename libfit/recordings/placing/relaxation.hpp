#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/placing/place.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"

namespace palpate::recordings {

/// Presses that speak of time: with a stand in contact, or of one point at several rates. Few
/// enough for the search, those that tell most first. points: candidates of each. Nothing where
/// none does.
struct TimedPoints {
  std::vector<std::vector<std::size_t>> member;  ///< candidates of each point
  std::vector<std::vector<RelaxingPress>> press;
  bool has_holds = false, has_rates = false;
};
TimedPoints presses_in_time(const std::vector<Candidate>& candidates,
                            const std::vector<std::vector<std::size_t>>& points,
                            const std::vector<BatchItem>& items);

/// Relaxation of a body from its recordings, and of each of its points that has a hold.
BodyRelaxation relaxation_of(const std::vector<Candidate>& candidates, const TimedPoints& timed,
                             const std::vector<BatchItem>& items);

/// Aligns the contacts of presses in time, point by point, for a body that relaxes as was found.
void align_points(std::vector<Candidate>& candidates,
                  const std::vector<std::vector<std::size_t>>& points,
                  const std::vector<BatchItem>& items, const RelaxationFit& body);

/// What was identified, in words.
std::vector<std::string> relaxation_notes(const BodyRelaxation& found);

/// Rows of a recording in time, from first to last touch of its deepest press; those of a drag or
/// path by way. Nothing without a clock.
std::optional<Pooled> in_time(const std::vector<Candidate>& candidates, std::size_t member);

}  // namespace palpate::recordings
