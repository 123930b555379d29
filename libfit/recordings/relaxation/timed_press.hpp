#pragma once

#include <optional>

#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// A recording as it went in time, in as few rows as its bends need: T rows, one after another.
/// Between rows the tool moves at constant speed.
struct TimedPress {
  Eigen::VectorXd time_s;     ///< T, rising; 0 at first touch
  Eigen::VectorXd depth_m;    ///< T, since contact; negative where the tool is free
  Eigen::VectorXd push_N;     ///< T, means of readings
  Eigen::VectorXd readings;   ///< T, independent ones of its mean; 0: a place of the path alone
  Points deflection_m{0, 3};  ///< T x 3 since contact, of recordings with three axes; else no rows
  Points force_N{0, 3};       ///< likewise
  double noise_N = 0;         ///< of one reading
  double contact_deviation_m = 0;  ///< 0: the contact is known

  Eigen::Index rows() const { return time_s.size(); }
};

/// Rows of a signal whose bias is taken off: parts of straight ways, over which neither depth nor
/// force nor time goes by more than a share. contact_m: of recordings with three axes. Saturated
/// readings and spikes give a place, no force. No rows without a clock, or where the tool goes to
/// and fro too often.
TimedPress timed_press(const Signal& signal, const std::optional<Vec3>& contact_m, double noise_N);

/// Time at which the depth is 0 before the row that is the first in contact.
double touch_time_s(const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m,
                    Eigen::Index first);

/// Share of the time in contact in which the tool stands: slower than a tenth of its mean speed on
/// the way there.
double held_share(const TimedPress& press);

/// Whether the force is held while the tool sinks (creep): for a tenth of the time or longer the
/// force is within 10 % of its largest. From the first third of that time to the last its mean
/// moves by less than 3 % and the depth grows by more than 2 %, slower than half the speed before.
bool is_creep(const TimedPress& press);

}  // namespace palpate::recordings
