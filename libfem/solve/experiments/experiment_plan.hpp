#pragma once

#include <optional>
#include <vector>

#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

/// A straight piece of where contact goes on the surface, from the test point, and the shallowest
/// depth there.
struct ContactSegment {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double depth_m = 0;
};

/// Place of a second probe: its test point, from the first one's, and its inward normal.
struct SecondPlace {
  Vec3 from_first_m, normal;
};

/// Rows of one test point, the paths of the probe that fill them, and the segments of the surface
/// that contact visits.
struct ExperimentPlan {
  SampleRows rows;  ///< not reached yet; of two tools that of the second comes after the first's
  std::vector<ProbePath> paths;
  std::vector<ContactSegment> segments;
  double depth_m = 0;  // deepest
  bool is_in_time = false;
  Lean lean = Lean::Zero();  // of the tool, all along
  std::optional<SecondPlace> second = std::nullopt;

  /// Appends a row of a tool and returns its number.
  int add_row(ExperimentKind kind, int experiment, int step, const Vec3& deflection, int tool = 0);
};

/// The press passes every row and every depth where a drag starts; drags branch off there.
ExperimentPlan press_and_drag_plan(const Experiments& experiments, const Vec3& normal);

/// Path 0 alone, a press, on meshes of the whole plan, so that grids differ in nothing but size.
/// All rows stay, those of other paths are never reached.
ExperimentPlan press_of(ExperimentPlan plan);

/// One experiment `path` along successive deflections from first touch, of both tools where there
/// are two.
ExperimentPlan path_plan(const ToolPath& path, const Vec3& position, const Vec3& normal);

/// A path with a straight press as deep beside it, path 0 of the plan; its few rows come last, as
/// experiment 1.
ExperimentPlan with_press(const ExperimentPlan& path, const Vec3& normal);

/// The plan of a press to which the body answers as it does at first, before anything has relaxed.
ExperimentPlan at_once(ExperimentPlan plan);

}  // namespace palpate::fem
