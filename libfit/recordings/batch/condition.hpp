#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/relaxation/timed_press.hpp"
#include "libfit/recordings/signal/settings.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// How far a recording can be trusted; poor ones are imported, and listed.
enum class Grade : std::int8_t { good = 0, fair = 1, poor = 2 };

/// Means of a press in cycles over levels of depth, in order.
struct CycleMeans {
  Eigen::VectorXd depth_m, push_N, error_N;
};

/// What is known of a recording beside its readings.
struct RecordingSource {
  std::string format;               ///< that the file was recognised as
  std::vector<std::string> taken;   ///< of the file beside the rows, a phrase each
  importers::UnitNames units = {};  ///< of position and force, as they were read
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
  /// From the deepest row, for comparing recordings; see apparent_modulus_Pa.
  double apparent_Pa = 0;
  Grade grade = Grade::good;
  std::vector<std::string> reasons;  ///< of the grade, a sentence each
  std::size_t dropped_rows = 0;
  RecordingSource source;
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

/// Young's modulus of an incompressible half-space that this tip would press to this depth with
/// this force; without a radius F / depth^2, the order of magnitude alone.
double apparent_modulus_Pa(double force_N, double depth_m, const SignalSettings& settings);

/// The presses of a recording with three axes, a recording for each place in the order pressed, "1"
/// to "9" in the recording's name: where the tool lifts off, goes sideways by more than either
/// press is deep, and presses again. The recording as it is where there is one place, and where
/// `condition` is going to refuse it. inward: unit, where the manifest says it.
std::vector<importers::RawRecording> split_places(const importers::RawRecording& raw,
                                                  const SignalSettings& settings,
                                                  const std::optional<Vec3>& inward,
                                                  bool drop_invalid);

}  // namespace palpate::recordings
