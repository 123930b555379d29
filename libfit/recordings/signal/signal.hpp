#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/recordings/formats/recording.hpp"

namespace palpate::recordings {

/// Correction of the force before contact: nothing, its mean, or its line over travel.
enum class Drift { none, bias, line };

/// Shape of the tip that pressed, for the contact estimate: force grows as depth to the power
/// 3/2 (sphere), 1 (flat) or 2 (cone).
enum class Tip { sphere, flat, cone };

/// The part of a press that its rows are from: the loading that goes farthest, or the mean of all
/// loadings and unloadings as far (the middle of the loop, on all readings).
enum class Use { approach, mean };

inline constexpr int kDeepestCycle = 0, kLastCycle = -1;

/// A contact point in the recording's own travel, and what found it.
struct FoundContact {
  double travel_m = 0, deviation_m = 0;
  std::string estimator = "given";  ///< that by the rig, or by its settings
  bool operator==(const FoundContact&) const = default;
};

/// The end of the tool that a recording was made with.
struct UsedTip {
  Tip tip = Tip::sphere;
  double radius_m = 0, half_angle_rad = 0;  ///< 0: unknown, or no cone
  bool operator==(const UsedTip&) const = default;
};

/// Options of turning the signals of one recording into samples.
struct SignalSettings : UsedTip {
  double force_delay_s = 0;                      ///< the force signal is this late
  double compliance_m_N = 0;                     ///< of the rig: travel that the body does not see
  double force_limit_N = kInfinity;              ///< of the sensor
  double min_young_Pa = 10, max_young_Pa = 5e6;  ///< apparent moduli outside are questioned
  bool is_range_given = false;  ///< by the user: recordings are not questioned by each other then
  ExperimentKind kind = ExperimentKind::press;
  std::string contact = "auto";                    ///< a name of kContactEstimators
  std::optional<FoundContact> known_contact = {};  ///< by the rig; nothing is estimated then
  Drift drift = Drift::bias;
  /// Positions are of the tip's centre: where it touches lies a radius further inward. Of
  /// recordings with three axes, and tips with a radius alone.
  bool is_position_of_center = false;
  double poisson = 0.5;  ///< of the body
  double smooth_s = 0;   ///< standard deviation of the Gaussian filter, which has no delay
  Use use = Use::approach;
  /// Of the presses of a recording that go as deep: its number from 1 on, kLastCycle, or
  /// kDeepestCycle, the one that goes farthest.
  int cycle = kDeepestCycle;
  int rows = 40;  ///< per experiment, at most
  /// Rows are readings in time: of a scan, or beside one, where a press begins with its approach.
  bool is_pass = false;
  bool operator==(const SignalSettings&) const = default;
};

/// Phase of the tip in a row.
enum class Phase : char { approach, hold, retract, slide };

/// Rows [begin, end).
struct RowRange {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index rows() const { return end - begin; }
};

/// The parts of a signal that samples are made from.
struct SignalRanges {
  RowRange approach;   ///< the loading that the settings ask for, up to its deepest row
  RowRange loading;    ///< its part in which the force rises
  RowRange unloading;  ///< after it; empty where there is none
  std::optional<Eigen::Index> break_in;  ///< last row before the tool breaks in
  /// Ranges that rows are means of, the last of them with the contact point.
  std::vector<RowRange> used;
};

/// Tip and force on one clock, N rows in the order recorded. A one-axis recording has its travel
/// and push in the first column, and inward (1, 0, 0). Each step from `align` to rows fills in what
/// it finds; what is not known yet is empty.
struct Signal {
  std::vector<double> time_s;  ///< N, or empty without a clock
  Points position_m;           ///< N x 3, the rig's compliance taken off
  Points force_N;              ///< N x 3, of the tip ON the body
  Points torque_Nm{0, 3};      ///< N x 3 about the tip, likewise; or none
  Vec3 inward = Vec3::UnitX();
  std::vector<std::size_t> line;   ///< N, in the file
  std::vector<char> is_saturated;  ///< N
  std::vector<char> is_spike;      ///< N; force replaced by that of its neighbours
  bool is_axial = false;
  /// N, as recorded, before spikes, filter and bias go.
  Eigen::VectorXd recorded_travel_m, recorded_push_N;
  std::vector<Phase> phase;  ///< N
  SignalRanges range;
  double contact_m = 0;    ///< travel at first touch
  Eigen::VectorXd bias_N;  ///< N, taken off the push
  /// Of neighbours in the noise before contact; 0 where nothing is free.
  double correlation = 0;

  Eigen::Index rows() const { return position_m.rows(); }
  Eigen::VectorXd travel_m() const { return position_m * inward; }
  Eigen::VectorXd push_N() const { return force_N * inward; }
};

/// Brings position and force to one clock: force rows stay as they are (its delay taken off their
/// time), the position is interpolated linearly between its own rows. Marks saturated rows: at the
/// sensor's limit, or stuck at one value far from the free one while the tip goes on. Takes off the
/// travel that the rig itself gives. inward: unit, where known.
/// Throws Error (file:line) on time stamps that repeat or go back, fewer than 5 common rows, and
/// clocks that do not overlap.
Signal align(const importers::RawRecording& raw, const SignalSettings& settings,
             const std::optional<Vec3>& inward, const std::string& file);

/// Replaces single readings of the force that stand out on one side of the three before and the
/// three after (by 6 deviations of the noise, 5 steps between those neighbours and 2 % of the
/// range) by the line between their neighbours, marks them, and returns how many they are. Steps,
/// turning points and plateaus stay. Does nothing where more than a tenth of the rows would go.
std::size_t replace_spikes(Signal& signal);

/// Low-pass filter without delay: at each row the value of a straight line fitted with Gaussian
/// weights in time, standard deviation sigma_s (half power at 0.13 / sigma_s), so it keeps ramps
/// and ends unbiased. Precondition: the signal has a clock. Source: Cleveland and Loader (1996),
/// local regression.
void smooth(Signal& signal, double sigma_s);

/// Median of a normal variable's size, in deviations.
inline constexpr double kMedianOfNormal = 0.6745;

/// Standard deviation of neighbouring values about straight lines through three of them: the noise
/// of a signal that bends slowly. 0 below three values.
double neighbour_scatter(const Eigen::VectorXd& values);

/// Least difference between values of a sensor so coarse that neighbours are often equal; else 0.
/// Precondition: at least one value.
double quantum_of(const Eigen::VectorXd& values);

/// Least squares y = at_0 + slope x without what lies five robust deviations off; deviation of the
/// residuals, and how far neighbours among them go together (their correlation).
struct Line {
  double at_0 = 0, slope = 0, deviation = 0, correlation = 0;
};
Line fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

/// Phase of the tip, row by row: it changes direction where the travel turns back by more than 2 %
/// of its whole range; it slides where it goes farther sideways than inward, and holds where over a
/// 2 % window of the rows it goes neither way by more than a tenth of the mean speed.
std::vector<Phase> find_phases(const Signal& signal);

/// The approach that gains most travel, from its lowest to its highest. Empty
/// when there is none.
RowRange main_approach(const Signal& signal);

/// The other approaches and the retracts that go at least 90 % as far as `approach` does, from
/// where it begins to where it ends: cycles of one recording.
std::vector<RowRange> cycles_like(const Signal& signal, const RowRange& approach);

/// All approaches, each from its lowest to its highest travel.
std::vector<RowRange> approaches(const Signal& signal);

/// Those that go at least 90 % as far as `approach` does, itself among them: presses of one
/// recording.
std::vector<RowRange> presses_like(const Signal& signal, const RowRange& approach);

/// The row of an approach behind which the push falls at once, by a fifth and out of noise and
/// waves, as the tool goes on: there it breaks in. Nothing where it does not.
std::optional<Eigen::Index> break_in_row(const Signal& signal, const RowRange& range);

/// The retract after it, to where the next approach begins; empty when there is none.
RowRange retract_after(const Signal& signal, const RowRange& approach);

/// At most 200 rows for a picture: half of them equally spaced over all, half over the approach
/// from as far before the contact point as the press goes beyond it; and those of largest push and
/// travel. Without readings of a signal that is empty.
SignalTrace trace_of(const Signal& signal);

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

}  // namespace palpate::recordings
