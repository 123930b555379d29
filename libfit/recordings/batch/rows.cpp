#include <algorithm>
#include <cmath>

#include "libfit/recordings/batch/steps.hpp"

namespace palpate::recordings {
namespace {

constexpr int kLevels = 20;  // of depth, to each way in or out of a cycle

// Where along the rows' abscissa each signal row lies: depth, or length of the path since contact.
Eigen::VectorXd abscissa(const Signal& signal, const RowRange& used, Eigen::Index touched,
                         double contact_travel_m, bool is_press) {
  Eigen::VectorXd at = Eigen::VectorXd::Constant(used.rows(), -1);
  const Eigen::VectorXd depth =
      signal.travel_m().segment(used.begin, used.rows()).array() - contact_travel_m;
  if (is_press) return depth;
  // Path of the tip, in strides of a hundredth of its range so that noise does not lengthen it.
  const auto part = signal.position_m.middleRows(used.begin, used.rows());
  const double stride_m = 0.01 * (part.colwise().maxCoeff() - part.colwise().minCoeff()).norm();
  double path_m = 0;
  Vec3 last = part.row(touched);
  for (Eigen::Index i = touched; i < used.rows(); ++i) {
    const double step_m = (Vec3(part.row(i)) - last).norm();
    at[i] = path_m + step_m;
    if (step_m > stride_m) {
      path_m += step_m;
      last = part.row(i);
    }
  }
  return at;
}

// Error of a mean of `count` readings, of which neighbours correlate.
double error_of_mean_N(double noise_N, double count, double correlation) {
  return noise_N / std::sqrt(std::max(1.0, count * (1 - correlation) / (1 + correlation)));
}

}  // namespace

void take_rows(const Signal& signal, const SignalSettings& settings, Conditioned& out) {
  const RowRange& used = signal.range.used.back();
  const double contact_travel_m = signal.contact_m;
  const bool is_press = settings.kind == ExperimentKind::press;
  const Eigen::VectorXd travel = signal.travel_m().segment(used.begin, used.rows());
  Eigen::Index touched = 0;
  while (touched + 1 < travel.size() && travel[touched] < contact_travel_m) ++touched;
  const Eigen::VectorXd at = abscissa(signal, used, touched, contact_travel_m, is_press);
  const double most = at.maxCoeff();
  const Vec3 contact =
      signal.is_axial || !out.contact_m ? Vec3(contact_travel_m * signal.inward) : *out.contact_m;

  struct RowMean {
    Vec3 deflection = Vec3::Zero(), force = Vec3::Zero(), torque = Vec3::Zero();
    double count = 0, time_s = 0;
    bool is_saturated = false;
  };
  std::vector<RowMean> means(static_cast<std::size_t>(std::max(1, settings.rows)));
  const auto add = [&](Eigen::Index row, double where) {
    if (!(where > 0) || where > most || signal.is_spike[row]) return;
    const auto bin =
        std::min(means.size() - 1,
                 static_cast<std::size_t>(where / most * static_cast<double>(means.size())));
    RowMean& mean = means[bin];
    mean.deflection += Vec3(signal.position_m.row(row)) - contact;
    mean.force += signal.force_N.row(row);
    if (signal.torque_Nm.rows() > 0) mean.torque += signal.torque_Nm.row(row);
    mean.count += 1;
    if (!signal.time_s.empty()) mean.time_s += signal.time_s[row];
    mean.is_saturated |= signal.is_saturated[row] != 0;
  };
  for (Eigen::Index i = 0; i < used.rows(); ++i) add(used.begin + i, at[i]);
  for (std::size_t k = 0; k + 1 < signal.range.used.size(); ++k)
    for (Eigen::Index row = signal.range.used[k].begin; row < signal.range.used[k].end; ++row)
      add(row, signal.position_m.row(row).dot(signal.inward) - contact_travel_m);
  std::erase_if(means, [](const RowMean& mean) { return mean.count == 0; });
  const Eigen::Index rows = means.size();
  out.deflection_m.resize(rows, 3);
  out.force_N.resize(rows, 3);
  out.error_N.resize(rows);
  out.time_s.resize(signal.time_s.empty() ? 0 : rows);
  out.torque_Nm.resize(signal.torque_Nm.rows() > 0 ? rows : 0, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RowMean& mean = means[i];
    out.deflection_m.row(i) = mean.deflection / mean.count;
    out.force_N.row(i) = mean.force / mean.count;
    if (out.torque_Nm.rows() > 0) out.torque_Nm.row(i) = mean.torque / mean.count;
    if (out.time_s.size() > 0)
      out.time_s[i] = mean.time_s / mean.count - signal.time_s[used.begin + touched];
    out.error_N[i] = error_of_mean_N(out.noise_N, mean.count, signal.correlation);
    out.status.push_back(mean.is_saturated ? RowStatus::rejected : RowStatus::good);
  }
}

void take_cycles(const Signal& signal, Conditioned& out) {
  const Eigen::VectorXd depth = signal.travel_m().array() - signal.contact_m,
                        push = signal.push_N();
  const double level_m = depth.maxCoeff() / kLevels;
  struct Mean {
    double depth_m = 0, push_N = 0, count = 0;
    Phase phase = Phase::hold;
    int level = 0;
  };
  std::vector<Mean> means;
  for (Eigen::Index i = 0; i < depth.size(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const Phase phase = signal.phase[row];
    if (signal.is_saturated[row]) break;
    if (signal.is_spike[row] || !(depth[i] > 0)) continue;
    if (phase != Phase::approach && phase != Phase::retract) continue;
    const int level = static_cast<int>(depth[i] / level_m);
    if (means.empty() || means.back().phase != phase || means.back().level != level)
      means.push_back({0, 0, 0, phase, level});
    means.back().depth_m += depth[i];
    means.back().push_N += push[i];
    ++means.back().count;
  }
  const Eigen::Index rows = means.size();
  for (Eigen::VectorXd* column : {&out.cycles.depth_m, &out.cycles.push_N, &out.cycles.error_N})
    column->resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Mean& mean = means[i];
    out.cycles.depth_m[i] = mean.depth_m / mean.count;
    out.cycles.push_N[i] = mean.push_N / mean.count;
    out.cycles.error_N[i] = error_of_mean_N(out.noise_N, mean.count, signal.correlation);
  }
}

}  // namespace palpate::recordings
