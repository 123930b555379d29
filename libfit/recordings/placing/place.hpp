#pragma once

#include "libfit/recordings/placing/assemble.hpp"

// Steps of `assemble`, for this layer alone.

namespace palpate::recordings {

inline UsedTip tip_of(const std::vector<BatchItem>& items, const PlacedRecording& c) {
  return items[c.item].signal;
}

/// Finds place and inward normal of each candidate; refuses those that have none or lie elsewhere.
std::optional<Registration> place_on_body(const std::vector<BatchItem>& items,
                                          const AssembleOptions& options,
                                          std::vector<PlacedRecording>& candidates);

/// One experiment of the samples, in the body's frame.
struct Pooled : ExperimentRows {
  std::vector<std::size_t> member;  ///< recordings
  double speed_m_s = 0;
};

/// A recording's rows in the body's frame.
Pooled on_body(const std::vector<PlacedRecording>& candidates, std::size_t member);

/// Experiments of one point: presses at one rate are one. members: candidates of it, not refused.
std::vector<Pooled> pool(const std::vector<PlacedRecording>& candidates,
                         const std::vector<std::size_t>& members,
                         const std::vector<BatchItem>& items);

/// What rates and ways back do beyond the noise, a sentence each; empty when nothing stands out.
std::vector<std::string> compare_rates(const std::string& point,
                                       const std::vector<Pooled>& experiments,
                                       const std::vector<PlacedRecording>& candidates,
                                       const std::vector<BatchItem>& items);

/// Presses that speak of time: with a stand in contact, or of one point at several rates. Few
/// enough for the search, those that tell most first. points: candidates of each. Nothing where
/// none does.
struct TimedPoints {
  std::vector<std::vector<std::size_t>> member;  ///< candidates of each point
  std::vector<std::vector<TimedPress>> press;
  bool has_holds = false, has_rates = false;
};
TimedPoints presses_in_time(const std::vector<PlacedRecording>& candidates,
                            const std::vector<std::vector<std::size_t>>& points,
                            const std::vector<BatchItem>& items);

/// Relaxation of a body from its recordings, and of each of its points that has a hold.
BodyRelaxation relaxation_of(const std::vector<PlacedRecording>& candidates,
                             const TimedPoints& timed, const std::vector<BatchItem>& items);

/// Aligns the contacts of presses in time, point by point, for a body that relaxes as was found.
void align_points(std::vector<PlacedRecording>& candidates,
                  const std::vector<std::vector<std::size_t>>& points,
                  const std::vector<BatchItem>& items, const RelaxationFit& body);

/// What was identified, in words.
std::vector<std::string> relaxation_notes(const BodyRelaxation& found);

/// Rows of a recording in time, from first to last touch of its deepest press; those of a drag or
/// path by way. Nothing without a clock.
std::optional<Pooled> in_time(const std::vector<PlacedRecording>& candidates, std::size_t member);

}  // namespace palpate::recordings
