#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/relaxation/timed_press.hpp"

namespace palpate::recordings {

/// How far a recording can be trusted; poor ones are imported, and listed.
enum class Grade : std::int8_t { good = 0, fair = 1, poor = 2 };

inline constexpr double kSeenInErrors = 3;      ///< deviations
inline constexpr double kMinForceInNoise = 20;  ///< of a fair recording
inline constexpr double kMinEffect = 0.05;      ///< of a force or its work: below the JND

/// Means of a press in cycles over levels of depth, in order.
struct CycleMeans {
  Eigen::VectorXd depth_m, push_N, error_N;
};

/// Rows of one experiment: R of them, in the rig's frame or the body's.
struct ExperimentRows {
  Points deflection_m{0, 3};      ///< R x 3 since first touch
  Points force_N{0, 3};           ///< R x 3, of the tip ON the body, bias taken off
  Points torque_Nm{0, 3};         ///< R x 3, likewise; 0 rows where the recording has none
  Eigen::VectorXd time_s = {};    ///< R, since first touch; empty where rows have no time
  Eigen::VectorXd error_N;        ///< R, of a row's force, from the noise before contact
  std::vector<RowStatus> status;  ///< R; rejected where the force was saturated
};

/// One press, drag or path as samples, before it is known where on the body.
struct Conditioned : ExperimentRows {
  std::string name;               ///< within its file
  bool is_axial = false;          ///< deflection (depth, 0, 0), force (push, 0, 0)
  std::optional<Vec3> contact_m;  ///< where the tip touched, in the rig's frame
  std::optional<Vec3> inward;     ///< unit, in the rig's frame
  FoundContact contact;
  TimedPress history;     ///< of a press with a clock, all of it; else no rows
  double speed_m_s = 0;   ///< NaN without a clock
  double noise_N = 0;     ///< standard deviation of one reading without contact
  double hysteresis = 0;  ///< share of the work that unloading loses; NaN without all of it
  CycleMeans cycles;      ///< of a press in cycles that go deeper and deeper; else no rows
  bool breaks = false;    ///< the tool broke in: what lies deeper was left out
  double young_Pa = 0;    ///< apparent, of the contact fit; NaN without radius or fit
  /// Young's modulus of an incompressible half-space that its tip presses as deep as the deepest
  /// row with its force; without a radius F / depth^2, the order of magnitude alone.
  double apparent_Pa = 0;
  Grade grade = Grade::good;
  std::vector<std::string> reasons;  ///< of the grade, a sentence each
  std::size_t dropped_rows = 0;
  importers::RecordingSource source;
  SignalTrace trace;  ///< for a picture
};

/// Samples of a recording: one clock, filter, phases, contact point, bias, then R means over equal
/// steps of depth (press) or of the tip's path since contact (drag, path).
/// inward: unit, where the manifest or a surface says it. Throws Error (file:line, what, remedy) on
/// recordings from which no curve comes: no contact, reversed sign, saturated over most of the
/// depth, implausible stiffness, too few rows; what was seen of the signal then goes to `refused`.
Conditioned condition(const importers::RawRecording& raw, const SignalSettings& settings,
                      const std::optional<Vec3>& inward, const std::string& file, bool drop_invalid,
                      SignalTrace* refused = nullptr);

// Steps of `condition`, in their order.

/// Finds approach, loading, first loadings and break of the press that the settings ask for. Notes
/// in `out` that there are others as deep, and how they differ. Throws Error (file:line, what,
/// remedy) where the tip never goes in, or not as often as `cycle` asks for.
void find_ranges(const SignalSettings& settings, const std::string& file, Signal& signal,
                 Conditioned& out);

/// Finds the contact point as the settings ask for it, given or estimated from the loading and
/// `cycles`, takes the mean (or line) of the free push off all rows and axes of `signal`, and fills
/// in contact, noise and speed of `out`. Throws Error (file:line, what, remedy) where the loading
/// holds no contact or has the other sign.
ContactEstimate find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::string& file, const std::vector<RowRange>& cycles,
                             Signal& signal, Conditioned& out);

/// Fills the rows of `out` from the signal's used ranges: means over equal steps of depth for a
/// press, of the tip's path since contact for a drag or path. Errors are the noise over the square
/// root of the readings that count (neighbours with correlation r count (1 - r) / (1 + r)).
void take_rows(const Signal& signal, const SignalSettings& settings, Conditioned& out);

/// Means of a press in cycles over levels of depth, loading by unloading, into `out`.
void take_cycles(const Signal& signal, Conditioned& out);

/// The presses of a recording with three axes, a recording for each place in the order pressed, "1"
/// to "9" in the recording's name: where the tool lifts off, goes sideways by more than either
/// press is deep, and presses again. The recording as it is where there is one place, and where
/// `condition` is going to refuse it. inward: unit, where the manifest says it.
std::vector<importers::RawRecording> split_places(const importers::RawRecording& raw,
                                                  const SignalSettings& settings,
                                                  const std::optional<Vec3>& inward,
                                                  bool drop_invalid);

}  // namespace palpate::recordings
