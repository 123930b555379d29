#pragma once

#include <algorithm>

#include "libfit/recordings/placing/assemble.hpp"

// Steps of `assemble`, for this layer alone.

namespace palpate::recordings {

/// A recording on its way into the samples.
struct Candidate {
  std::size_t item = 0;
  const Conditioned* recording = nullptr;
  std::string point;               ///< its name
  Vec3 position_m = Vec3::Zero();  ///< on the body
  Vec3 inward = Vec3::UnitZ();
  Mat3 to_body = Mat3::Identity();  ///< turns its deflections and forces into the body's frame
  double surface_distance_m = 0;
  std::int32_t point_index = -1, experiment = -1;
  std::optional<ContactShift> aligned;  ///< with other recordings of its point
  std::optional<Failure> failure;
};

inline UsedTip tip_of(const std::vector<BatchItem>& items, const Candidate& c) {
  const SignalSettings& s = items[c.item].signal;
  return {s.tip, c.recording->source.tip_radius_m, s.half_angle_rad};
}

/// Which of the tips made a recording; 0 where it does not say.
inline std::int32_t tip_number(const std::vector<UsedTip>& tips,
                               const std::vector<BatchItem>& items, const Candidate& c) {
  const auto at = std::ranges::find(tips, tip_of(items, c));
  return at == tips.end() ? 0 : static_cast<std::int32_t>(at - tips.begin());
}

/// Finds place and inward normal of each candidate; refuses those that have none or lie elsewhere.
std::optional<Registration> place_on_body(const std::vector<BatchItem>& items,
                                          const AssembleOptions& options,
                                          std::vector<Candidate>& candidates);

/// One experiment of the samples.
struct Pooled {
  std::vector<std::size_t> member;           ///< candidates
  Points deflection_m{0, 3}, force_N{0, 3};  ///< in the body's frame
  Points torque_Nm{0, 3};                    ///< likewise; 0 rows where unknown
  Eigen::VectorXd error_N;
  std::vector<RowStatus> status;
  double speed_m_s = 0;
  Eigen::VectorXd time_s = {};  ///< since first touch; empty where rows are of no time
};

/// Experiments of one point: presses at one rate are one. members: candidates of it, not refused.
std::vector<Pooled> pool(const std::vector<Candidate>& candidates,
                         const std::vector<std::size_t>& members,
                         const std::vector<BatchItem>& items);

/// What rates and ways back do beyond the noise, a sentence each; empty when nothing stands out.
std::vector<std::string> compare_rates(const std::string& point,
                                       const std::vector<Pooled>& experiments,
                                       const std::vector<Candidate>& candidates,
                                       const std::vector<BatchItem>& items);

/// "file.csv" or "file.csv#name".
std::string shown(const std::vector<BatchItem>& items, const Candidate& candidate);

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
