#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "libfit/core/statistics.hpp"
#include "libfit/recordings/batch/batch.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinPasses = 8;

double median_step_s(const std::vector<double>& time_s) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  return upper_median(steps);
}

// Rows at which a slow tool turns back along the direction that it mostly moves in: by a twentieth
// of its range. slow: positions without the presses.
std::vector<Eigen::Index> turns_of(const Points& slow) {
  const Points step = slow.bottomRows(slow.rows() - 1) - slow.topRows(slow.rows() - 1);
  const Eigen::SelfAdjointEigenSolver<Mat3> spread(Mat3(step.transpose() * step));
  const Eigen::VectorXd place = slow * spread.eigenvectors().col(2);
  const double least_m = 0.05 * (place.maxCoeff() - place.minCoeff());
  std::vector<Eigen::Index> turns;
  Eigen::Index farthest = 0;
  double direction = 0;
  for (Eigen::Index row = 1; row < place.size(); ++row) {
    const double gone_m = place[row] - place[farthest];
    if (direction == 0 && std::abs(gone_m) > least_m) {
      direction = gone_m > 0 ? 1 : -1;
      farthest = row;
    } else if (direction * gone_m > 0) {
      farthest = row;
    } else if (direction * gone_m < -least_m) {
      turns.push_back(farthest);
      direction = -direction;
      farthest = row;
    }
  }
  return turns;
}

// Rows at which passes begin, and the end: at turns, or where there are few at equal times; each
// moved to the smallest force within a third of a second, where the contact remembers least.
std::vector<Eigen::Index> begins_of(const Signal& signal) {
  const double step_s = median_step_s(signal.time_s);
  Signal slow = signal;
  smooth(slow, 0.35);  // s: presses of 1 Hz and faster are no turns
  std::vector<Eigen::Index> inner = turns_of(slow.position_m);
  if (std::ssize(inner) + 1 < kMinPasses) {
    inner.clear();
    for (Eigen::Index k = 1; k < 2 * kMinPasses; ++k)
      inner.push_back(signal.rows() * k / (2 * kMinPasses));
  }
  const Eigen::VectorXd force_N = signal.force_N.rowwise().norm();
  const auto near = static_cast<Eigen::Index>(0.3 / step_s);
  std::vector<Eigen::Index> out{0};
  for (const Eigen::Index turn : inner) {
    const Eigen::Index from = std::max<Eigen::Index>(turn - near, out.back() + 10),
                       to = std::min(turn + near + 1, signal.rows() - 10);
    if (to <= from) continue;
    Eigen::Index least = 0;
    force_N.segment(from, to - from).minCoeff(&least);
    out.push_back(from + least);
  }
  out.push_back(signal.rows());
  return out;
}

// Unless its sign is wrong, the force rises along its mean direction where the tool goes on along
// that, and friction on the body points to where the tool slides.
void check_sign(const Signal& signal, const Vec3& push, const std::string& file) {
  const Vec3 along = push.normalized();
  const Mat3 lateral = Mat3::Identity() - along * along.transpose();
  const Eigen::Index lag = 5;  // rows, over which the force rises by more than its noise
  double both = 0, travel = 0, force = 0, friction_N = 0, lateral_N = 0;
  for (Eigen::Index row = lag; row < signal.rows(); ++row) {
    const Vec3 step = signal.position_m.row(row) - signal.position_m.row(row - lag),
               rise = signal.force_N.row(row) - signal.force_N.row(row - lag),
               aside = lateral * (signal.force_N.row(row).transpose() - push);
    const double dx = along.dot(step), df = along.dot(rise);
    both += dx * df, travel += dx * dx, force += df * df;
    friction_N += aside.dot((lateral * step).normalized()), lateral_N += aside.norm();
  }
  const bool falls = both < -0.3 * std::sqrt(travel * force);
  // The share of friction is 0.42 to 0.80 in six scans of organs and three under force control. A
  // wrong sign negates it: half of the bound and twice decide alike.
  if (falls || friction_N < -0.2 * lateral_N)
    throw Error(file, falls ? "the force falls as the tool goes in" : "friction drives the tool",
                "Say whose force it is: force_on = \"tool\" or \"body\".");
}

}  // namespace

void check_pass_settings(const SignalSettings& settings, const std::string& file) {
  const bool is_scan = settings.kind == ExperimentKind::scan;
  if (!(is_scan &&
        (settings.contact != "auto" || settings.smooth_s > 0 || settings.cycle != kDeepestCycle)) &&
      settings.use == Use::approach && !settings.is_position_of_center &&
      settings.rows == SignalSettings().rows)
    return;
  throw Error(file,
              is_scan ? "contact, smooth, cycle, positions and rows do nothing for a scan"
                      : "cycle = \"mean\", positions and rows do nothing beside a scan",
              "Leave them out: the surface is found with the curves, from every reading.");
}

std::vector<Conditioned> condition_scan(const importers::RawRecording& raw,
                                        const SignalSettings& settings,
                                        const std::optional<Vec3>& inward,
                                        const std::string& file) {
  if (raw.is_axial() || raw.time_s.empty() || raw.force_N.rows() == 0)
    throw Error(file, "a scan needs a clock, and positions and forces of three axes",
                "Name `time`, `position` and `force` columns.");
  check_pass_settings(settings, file);
  Conditioned all;
  Signal signal = align(raw, settings, inward, file);
  const std::size_t spikes = replace_spikes(signal);
  const Eigen::Index least = 400;  // eight passes of 50 rows
  if (signal.rows() < least)
    throw Error(file, fmt::format("has {} rows, and a scan needs {}", signal.rows(), least),
                "Record longer, or say kind = \"path\".");
  const Vec3 push = signal.force_N.colwise().mean();
  if (!inward && !(push.norm() > 0)) throw Error(file, "has no force", "Check `columns`.");
  all.source = raw;
  all.inward = inward ? *inward : push.normalized();
  for (int k = 0; k < 3; ++k)
    all.noise_N = std::max(all.noise_N, neighbour_scatter(signal.force_N.col(k)));
  all.hysteresis = all.young_Pa = all.apparent_Pa = kNan;
  if (spikes > 0) all.reasons.push_back(fmt::format("{} single readings were left out", spikes));
  check_sign(signal, push, file);
  const std::vector<Eigen::Index> begins = begins_of(signal);
  std::vector<Conditioned> passes;
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    const Eigen::Index first = begins[k], rows = begins[k + 1] - first;
    Conditioned& pass = passes.emplace_back(all);
    pass.name = fmt::format("{}", k + 1);
    pass.contact_m = signal.position_m.row(first);
    pass.deflection_m =
        signal.position_m.middleRows(first, rows).rowwise() - signal.position_m.row(first);
    pass.force_N = signal.force_N.middleRows(first, rows);
    pass.time_s = Eigen::Map<const Eigen::VectorXd>(signal.time_s.data() + first, rows);
    const double length_m =
        (pass.deflection_m.bottomRows(rows - 1) - pass.deflection_m.topRows(rows - 1))
            .rowwise()
            .norm()
            .sum();
    pass.speed_m_s = length_m / (pass.time_s[rows - 1] - pass.time_s[0]);
    pass.time_s.array() -= signal.time_s.front();
    pass.error_N = Eigen::VectorXd::Constant(rows, pass.noise_N);
    for (Eigen::Index i = 0; i < rows; ++i)
      pass.status.push_back(signal.is_saturated[first + i] ? RowStatus::rejected : RowStatus::good);
  }
  return passes;
}

}  // namespace palpate::recordings
