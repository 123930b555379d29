#include <cmath>

#include "libfit/recordings/batch/condition.hpp"

namespace palpate::recordings {
namespace {

constexpr int kLevels = 20;  // of depth, to each way in or out

}  // namespace

void take_cycles(const Signal& signal, const std::vector<Phase>& phases, double contact_travel_m,
                 double correlation, Conditioned& out) {
  const Eigen::VectorXd depth = signal.travel_m().array() - contact_travel_m,
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
    const Phase phase = phases[row];
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
  const auto rows = static_cast<Eigen::Index>(means.size());
  for (Eigen::VectorXd* column : {&out.cycles.depth_m, &out.cycles.push_N, &out.cycles.error_N})
    column->resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Mean& mean = means[static_cast<std::size_t>(i)];
    out.cycles.depth_m[i] = mean.depth_m / mean.count;
    out.cycles.push_N[i] = mean.push_N / mean.count;
    const double independent = std::max(1.0, mean.count * (1 - correlation) / (1 + correlation));
    out.cycles.error_N[i] = out.noise_N / std::sqrt(independent);
  }
}

}  // namespace palpate::recordings
