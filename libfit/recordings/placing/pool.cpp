#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/place.hpp"

namespace palpate::recordings {
namespace {

constexpr double kSameRate = 1.25;  // repeats differ by less; a series of rates by more
constexpr double kSeenInErrors = 3;
constexpr double kMinEffect = 0.05;  // below the force JND nobody feels it

Eigen::VectorXd depths(const Pooled& p, const Vec3& inward) { return p.deflection_m * inward; }

struct At {
  Vec3 deflection = Vec3::Zero(), force = Vec3::Zero(), torque = Vec3::Zero();
  double error_N = 0;
};

At row_of(const Pooled& p, Eigen::Index i) {
  return {p.deflection_m.row(i), p.force_N.row(i),
          p.torque_Nm.rows() > 0 ? Vec3(p.torque_Nm.row(i)) : Vec3(Vec3::Zero()), p.error_N[i]};
}

// Row values at a depth, linear between good rows and through the origin; nothing beyond the last.
std::optional<At> interpolate(const Pooled& p, const Eigen::VectorXd& depth_m, double at_m) {
  double before_m = 0;
  At before;
  for (Eigen::Index i = 0; i < depth_m.size(); ++i) {
    if (p.status[i] != RowStatus::good) continue;
    if (depth_m[i] < at_m) {
      before_m = depth_m[i];
      before = row_of(p, i);
      continue;
    }
    const double share = depth_m[i] > before_m ? (at_m - before_m) / (depth_m[i] - before_m) : 1;
    At at = row_of(p, i);
    at.deflection = (1 - share) * before.deflection + share * at.deflection;
    at.force = (1 - share) * before.force + share * at.force;
    at.torque = (1 - share) * before.torque + share * at.torque;
    return at;
  }
  return std::nullopt;
}

// Means of presses at common depths, their scatter as error. Depths run as far as two of them
// reach.
Pooled together(const std::vector<Pooled>& repeats, const Vec3& inward) {
  std::vector<double> reach;
  std::vector<Eigen::VectorXd> depth;
  Eigen::Index rows = 0;
  for (const Pooled& p : repeats) {
    depth.push_back(depths(p, inward));
    double deepest = 0;
    for (Eigen::Index i = 0; i < depth.back().size(); ++i)
      if (p.status[i] == RowStatus::good) deepest = std::max(deepest, depth.back()[i]);
    reach.push_back(deepest);
    rows = std::max(rows, depth.back().size());
  }
  std::sort(reach.rbegin(), reach.rend());
  Pooled out;
  for (const Pooled& p : repeats) {
    out.member.push_back(p.member[0]);
    out.speed_m_s += p.speed_m_s / static_cast<double>(repeats.size());
  }
  const bool has_torque =
      std::ranges::all_of(repeats, [](const Pooled& p) { return p.torque_Nm.rows() > 0; });
  out.deflection_m.resize(rows, 3), out.force_N.resize(rows, 3), out.torque_Nm.resize(rows, 3);
  out.error_N.resize(rows);
  Eigen::Index filled = 0;
  for (Eigen::Index i = 1; i <= rows; ++i) {
    const double at_m = reach[1] * static_cast<double>(i) / static_cast<double>(rows);
    At sum;
    double squares = 0, own = 0;
    int n = 0;
    for (std::size_t k = 0; k < repeats.size(); ++k) {
      const auto at = interpolate(repeats[k], depth[k], at_m * (1 - 1e-12));
      if (!at) continue;
      sum.deflection += at->deflection, sum.force += at->force, sum.torque += at->torque;
      squares += std::pow(at->force.dot(inward), 2);
      own += at->error_N * at->error_N;
      ++n;
    }
    if (n < 2) continue;
    const Vec3 mean = sum.force / n;
    out.deflection_m.row(filled) = sum.deflection / n;
    out.force_N.row(filled) = mean;
    out.torque_Nm.row(filled) = sum.torque / n;
    out.error_N[filled++] =
        std::sqrt(std::max(0.0, (squares - n * std::pow(mean.dot(inward), 2)) / (n - 1)) + own / n);
  }
  for (Points* vectors : {&out.deflection_m, &out.force_N}) vectors->conservativeResize(filled, 3);
  out.torque_Nm.conservativeResize(has_torque ? filled : 0, 3);
  out.error_N.conservativeResize(filled);
  out.status.assign(filled, RowStatus::good);
  return out;
}

std::string in_millimetres_per_second(double speed_m_s) { return millimetres(speed_m_s) + "/s"; }

}  // namespace

Pooled on_body(const std::vector<PlacedRecording>& candidates, std::size_t member) {
  const PlacedRecording& c = candidates[member];
  Pooled out{*c.recording, {member}, c.recording->speed_m_s};
  for (Points* vectors : {&out.deflection_m, &out.force_N, &out.torque_Nm})
    *vectors *= c.to_body.transpose();
  return out;
}

std::vector<Pooled> pool(const std::vector<PlacedRecording>& candidates,
                         const std::vector<std::size_t>& members,
                         const std::vector<BatchItem>& items) {
  std::vector<Pooled> experiments;
  std::vector<std::size_t> presses;
  for (const std::size_t m : members) {
    const SignalSettings& s = items[candidates[m].item].signal;
    if (s.kind == ExperimentKind::press)
      presses.push_back(m);
    else
      experiments.push_back(on_body(candidates, m));
  }
  // By tip and speed; recordings without a clock belong together.
  const auto speed = [&](std::size_t m) { return candidates[m].recording->speed_m_s; };
  const auto tip = [&](std::size_t m) { return tip_of(items, candidates[m]); };
  const auto key = [&](std::size_t m) {
    const UsedTip t = tip(m);
    return std::tuple(t.tip, t.radius_m, t.half_angle_rad);
  };
  std::stable_sort(presses.begin(), presses.end(), [&](std::size_t a, std::size_t b) {
    if (!(tip(a) == tip(b))) return key(a) < key(b);
    return std::isnan(speed(b)) ? !std::isnan(speed(a)) : speed(a) < speed(b);
  });
  for (std::size_t first = 0, last = 0; first < presses.size(); first = last) {
    std::vector<Pooled> repeats;
    for (last = first; last < presses.size(); ++last) {
      const double v0 = speed(presses[first]), v = speed(presses[last]);
      if (std::isnan(v0) != std::isnan(v) || v > kSameRate * v0) break;
      if (!(tip(presses[first]) == tip(presses[last]))) break;
      repeats.push_back(on_body(candidates, presses[last]));
    }
    if (repeats.size() > 1) {
      Pooled pooled = together(repeats, candidates[presses[first]].inward);
      if (pooled.force_N.rows() >= 3) {
        experiments.push_back(std::move(pooled));
        continue;
      }
    }
    for (Pooled& one : repeats) experiments.push_back(std::move(one));
  }
  std::stable_sort(experiments.begin(), experiments.end(), [](const Pooled& a, const Pooled& b) {
    return *std::min_element(a.member.begin(), a.member.end()) <
           *std::min_element(b.member.begin(), b.member.end());
  });
  // Rows are of slow motion unless relaxation is applied (experiments_in_time).
  for (Pooled& one : experiments) one.time_s.resize(0);
  return experiments;
}

std::vector<std::string> compare_rates(const std::string& point,
                                       const std::vector<Pooled>& experiments,
                                       const std::vector<PlacedRecording>& candidates,
                                       const std::vector<BatchItem>& items) {
  std::vector<std::string> notes;
  const Pooled *slow = nullptr, *fast = nullptr;
  for (const Pooled& p : experiments) {
    if (items[candidates[p.member[0]].item].signal.kind != ExperimentKind::press ||
        std::isnan(p.speed_m_s))
      continue;
    if (slow &&
        !(tip_of(items, candidates[p.member[0]]) == tip_of(items, candidates[slow->member[0]])))
      continue;
    if (!slow || p.speed_m_s < slow->speed_m_s) slow = &p;
    if (!fast || p.speed_m_s > fast->speed_m_s) fast = &p;
  }
  if (slow && fast->speed_m_s > kSameRate * slow->speed_m_s) {
    const Vec3 inward = candidates[slow->member[0]].inward;
    const Eigen::VectorXd slow_depth = depths(*slow, inward), fast_depth = depths(*fast, inward);
    double difference = 0, force = 0, error = 0;
    for (Eigen::Index i = 0; i < slow_depth.size(); ++i) {
      if (slow->status[i] != RowStatus::good) continue;
      const auto at = interpolate(*fast, fast_depth, slow_depth[i]);
      if (!at) continue;
      difference += (at->force - Vec3(slow->force_N.row(i))).dot(inward);
      force += slow->force_N.row(i).norm();
      error += std::hypot(at->error_N, slow->error_N[i]);
    }
    if (std::abs(difference) > kSeenInErrors * error && std::abs(difference) > kMinEffect * force)
      notes.push_back("point " + point + ": the force at " +
                      in_millimetres_per_second(fast->speed_m_s) + " is " +
                      percent(std::abs(difference) / force, 0) +
                      (difference > 0 ? " above" : " below") + " that at " +
                      in_millimetres_per_second(slow->speed_m_s) + ", more than the noise");
  }
  double loss = 0;
  int n = 0;
  for (const Pooled& p : experiments)
    for (const std::size_t m : p.member)
      if (const Conditioned& r = *candidates[m].recording;
          std::isfinite(r.hysteresis) && r.noise_N * 20 < r.force_N.rowwise().norm().maxCoeff()) {
        loss += r.hysteresis;
        ++n;
      }
  if (n > 0 && loss / n > kMinEffect)
    notes.push_back("point " + point + ": " + percent(loss / n, 0) +
                    " of the work of pressing is not given back on the way out");
  return notes;
}

}  // namespace palpate::recordings
