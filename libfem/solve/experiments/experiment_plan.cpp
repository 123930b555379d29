#include "libfem/solve/experiments/simulator_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "libfem/probes/shapes.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {

int ExperimentPlan::add_row(ExperimentKind kind, int experiment, int step, const Vec3& deflection,
                            int tool) {
  const Eigen::Index row = rows.rows();
  rows.point.push_back(tool);
  rows.experiment.push_back(experiment);
  rows.kind.push_back(kind);
  rows.step.push_back(step);
  rows.tool.push_back(tool);
  rows.status.push_back(RowStatus::not_reached);
  rows.step_check.push_back(StepCheck::none);
  rows.deflection.conservativeResize(row + 1, 3);
  rows.deflection.row(row) = deflection.transpose();
  rows.force.setZero(row + 1, 3);
  rows.torque.setZero(row + 1, 3);
  rows.force_error.setConstant(row + 1, std::numeric_limits<double>::quiet_NaN());
  return static_cast<int>(row);
}

void ExperimentPlan::add_segments(const Points& deflections, const Vec3& from, const Vec3& normal) {
  Vec3 before = from;
  double depth_before = 0;
  for (Eigen::Index i = 0; i < deflections.rows(); ++i) {
    const Vec3 here = deflections.row(i);
    const double depth = here.dot(normal);
    depth_m = std::max(depth_m, depth);
    const Vec3 lateral = from + here - depth * normal;
    segments.push_back({before, lateral, std::min(depth, depth_before)});
    before = lateral;
    depth_before = depth;
  }
}

ExperimentPlan press_and_drag_plan(const Experiments& experiments, const Vec3& normal) {
  ExperimentPlan plan;
  plan.depth_m = experiments.depth_m;
  plan.segments.push_back({});
  struct Stop {
    double depth_m;
    int row;
  };
  std::vector<Stop> stops;
  for (int step = 1; step <= experiments.press_steps; ++step) {
    const double depth = experiments.depth_m * step / experiments.press_steps;
    stops.push_back({depth, plan.add_row(ExperimentKind::press, 0, step - 1, depth * normal)});
  }
  const double same = 1e-9 * experiments.depth_m;
  const auto stop_at = [&](double depth) {
    return std::find_if(stops.begin(), stops.end(),
                        [&](const Stop& stop) { return std::abs(stop.depth_m - depth) <= same; });
  };
  for (const double depth : experiments.drag_depths_m)
    if (stop_at(depth) == stops.end()) stops.push_back({depth, -1});
  std::stable_sort(stops.begin(), stops.end(),
                   [](const Stop& a, const Stop& b) { return a.depth_m < b.depth_m; });
  plan.paths.emplace_back();
  for (const Stop& stop : stops)
    plan.paths[0].targets.push_back({stop.depth_m * normal, stop.row, true});

  int experiment = 1;
  for (const double depth : experiments.drag_depths_m) {
    for (const Vec3& tangent : drag_tangents(normal, experiments.drag_directions)) {
      ProbePath drag{0, static_cast<int>(stop_at(depth) - stops.begin()), {}};
      // The last row is back at the start: on the outward stroke friction and the gradient of the
      // force along the drag are one number.
      const int out = std::max(1, experiments.drag_steps - 1);
      for (int step = 1; step <= experiments.drag_steps; ++step) {
        const double share = step <= out ? std::pow(double(step) / out, 1.5) : 0;
        const Vec3 deflection = depth * normal + share * experiments.drag_distance_m * tangent;
        drag.targets.push_back(
            {deflection, plan.add_row(ExperimentKind::drag, experiment, step - 1, deflection)});
      }
      plan.paths.push_back(drag);
      plan.segments.push_back({Vec3::Zero(), experiments.drag_distance_m * tangent, depth});
      ++experiment;
    }
  }
  return plan;
}

ExperimentPlan path_plan(const ToolPath& path, const Vec3& position, const Vec3& normal) {
  const Points& deflections = path.deflections;
  const Eigen::VectorXd& time_s = path.time_s;
  ExperimentPlan plan;
  plan.lean = path.lean;
  plan.is_in_time = time_s.size() > 0;
  plan.paths.emplace_back();
  for (Eigen::Index i = 0; i < deflections.rows(); ++i) {
    const Vec3 here = deflections.row(i);
    const int step = static_cast<int>(i), row = plan.add_row(ExperimentKind::path, 0, step, here);
    if (path.second)
      plan.add_row(ExperimentKind::path, 0, step, path.second->deflections.row(i), 1);
    plan.paths[0].targets.push_back({here, row});
    if (plan.is_in_time) plan.paths[0].targets.back().time_s = time_s[i];
  }
  plan.add_segments(deflections, Vec3::Zero(), normal);
  if (plan.is_in_time)
    plan.rows.time_s =
        path.second ? Eigen::VectorXd(time_s.replicate(1, 2).transpose().reshaped()) : time_s;
  if (!path.second) return plan;
  const SecondTool& other = *path.second;
  plan.second = {other.position - position, other.normal};
  for (Eigen::Index i = 0; i < deflections.rows(); ++i)
    plan.paths[0].targets[i].second_deflection = other.deflections.row(i);
  plan.add_segments(other.deflections, plan.second->from_first_m, other.normal);
  return plan;
}

ExperimentPlan with_press(const ExperimentPlan& path, const Vec3& normal) {
  constexpr int kRows = 3;
  ExperimentPlan plan = path;
  ProbePath press;
  for (int step = 1; step <= kRows; ++step) {
    const Vec3 deflection = plan.depth_m * step / kRows * normal;
    press.targets.push_back(
        {deflection, plan.add_row(ExperimentKind::press, 1, step - 1, deflection), true});
  }
  plan.paths.insert(plan.paths.begin(), std::move(press));
  return plan;
}

std::vector<Vec3> drag_tangents(const Vec3& normal, int count) {
  const Mat3 frame = probe_frame(normal);
  std::vector<Vec3> out;
  for (int k = 0; k < count; ++k) {
    const double angle = k * (2 * std::numbers::pi) / (count == 2 ? 4 : count);
    out.push_back(std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1));
  }
  return out;
}

namespace {

// Depths over the deepest: in and out, twice, and in.
constexpr std::array kCycle{0.17, 0.33, 0.5, 0.4, 0.25, 0.1, 0.25, 0.4, 0.5, 0.75,
                            1.0,  0.85, 0.7, 0.5, 0.3,  0.1, 0.3,  0.6, 0.8, 1.0};
// A press beforehand; the last row is out of touch.
constexpr std::array kBefore{0.3, 0.65, 1.0, 0.5, -0.05};

}  // namespace

ToolPath cycled_press(int point, const Vec3& inward, double depth_m) {
  ToolPath path{point, Points(kCycle.size(), 3)};
  for (std::size_t i = 0; i < kCycle.size(); ++i)
    path.deflections.row(i) = kCycle[i] * depth_m * inward.transpose();
  return path;
}

ToolPath after_press(const ToolPath& path, const Vec3& inward, double preload_m) {
  constexpr auto kRows = static_cast<Eigen::Index>(kBefore.size());
  ToolPath out = path;
  out.time_s = {};  // in slow motion, as the press before it
  out.deflections.resize(kRows + path.deflections.rows(), 3);
  for (Eigen::Index i = 0; i < kRows; ++i)
    out.deflections.row(i) = kBefore[i] * preload_m * inward.transpose();
  out.deflections.bottomRows(path.deflections.rows()) = path.deflections;
  return out;
}

ToolPath in_time(const ToolPath& path, double speed_m_s, double hold_s) {
  std::vector<Vec3> place;
  std::vector<double> time_s;
  Vec3 at = Vec3::Zero();
  double now_s = 0;
  for (Eigen::Index i = 0; i < path.deflections.rows(); ++i) {
    const Vec3 next = path.deflections.row(i);
    const double takes_s = (next - at).norm() / speed_m_s;
    at = next;
    if (!(now_s + takes_s > now_s)) continue;
    place.push_back(at);
    time_s.push_back(now_s += takes_s);
  }
  for (int k = 1; k <= kHoldRows && hold_s > 0; ++k) {
    place.push_back(at);
    time_s.push_back(now_s + hold_s * std::pow(10, 2.0 * (k - kHoldRows) / (kHoldRows - 1)));
  }
  ToolPath out = path;
  out.deflections.resize(place.size(), 3);
  out.time_s = Eigen::Map<const Eigen::VectorXd>(time_s.data(), time_s.size());
  for (std::size_t i = 0; i < place.size(); ++i) out.deflections.row(i) = place[i].transpose();
  return out;
}

}  // namespace palpate::fem
