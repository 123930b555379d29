#pragma once

#include <optional>
#include <vector>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/experiments/base_refinement.hpp"
#include "libfem/solve/experiments/experiment_plan.hpp"
#include "libfem/solve/experiments/mesh_transfer.hpp"
#include "libfem/solve/experiments/simulator.hpp"

// The state of a simulator, and a plan followed on one of its meshes.

namespace palpate::fem {

/// coarsening: of the sizes that the contact asks for. halved: base tets, see GradeOptions.
struct Fineness {
  double coarsening = 1;
  const std::vector<char>& halved;
};

/// A plan followed on one mesh.
struct MeshRun {
  std::vector<PathRow> rows;
  std::vector<Eigen::VectorXf> surface;  ///< of each row, where it is kept
  double touch_m = 0;
  int nodes = 0;
  SolverCounts counts;
  bool is_complete = true;  ///< not stopped
  QuadraticMesh mesh;       ///< and its displacements at all targets
  Waypoints reached;
};

/// The setup with its body about the middle of it, and what is made once of it.
struct Simulator::State {
  SimulationSetup setup;
  Vec3 origin = Vec3::Zero();  // middle of the body; volume and surface are about it
  TetMesh volume;
  SmoothSurface surface;
  std::vector<Material> materials;
  Probe probe;
  Points outward;  // of the surface's vertices

  QuadraticMesh mesh_at(const Vec3& position, const Vec3& normal, const ExperimentPlan& plan,
                        const Fineness& fineness) const;

  /// As it leans in the plan.
  Probe probe_of(const ExperimentPlan& plan, const Vec3& normal) const {
    return tilted(probe, normal, plan.lean, "[probe]");
  }
  RegionAt region_about(const Vec3& position) const;
  BedAt bed_about(const Vec3& position) const;
  PatchResponse patch_at(QuadraticMesh mesh, const ExperimentPlan& plan, const Vec3& position,
                         const Vec3& normal) const;
  BaseRefinement base_at(const ExperimentPlan& plan, const Vec3& position,
                         const Vec3& normal) const;
  MeshRun run(QuadraticMesh mesh, const ExperimentPlan& plan, const Vec3& position,
              const Vec3& normal, bool keeps_surface, const Progress& progress,
              const MeshRun* coarser = nullptr) const;
  bool sees_interface(const Vec3& position, const Probe& here, double depth_m) const;
  bool is_told_by_press(const ExperimentPlan& plan) const;     // the rest on the coarse grid alone
  ExperimentPlan fine_part(const ExperimentPlan& plan) const;  // what is solved on both grids
  PointRows experiment(const ExperimentPlan& plan, const BaseRefinement& base, const Vec3& position,
                       const Vec3& normal, const Progress& progress) const;
  PointRows quick_press(const ExperimentPlan& plan, const Vec3& position, const Vec3& normal,
                        const Progress& progress) const;
};

/// Writes forces, torques, errors and statuses of `out` [N rows, experiment after experiment] from
/// what was solved on two meshes, the coarse one `ratio` times as coarse: extrapolated experiment
/// by experiment, with the error (M13b), (M13c), of which min_error is the least share. coarse:
/// empty where there is one mesh.
void record_rows(const std::vector<PathRow>& fine, const std::vector<PathRow>& coarse, double ratio,
                 double min_error, SampleRows& out);

/// Writes the rows that are of no press from the coarse grid alone, times what the press's rows of
/// `out`, written before, have over those of the coarse grid (M13k). Their error is that of the
/// press (median) and what one factor for both leaves. All stays where the press has no such rows.
void record_by_press(const std::vector<PathRow>& coarse, SampleRows& out);

/// Good rows of presses whose force stands more than 45 degrees off `normal`, along which they go
/// in, become `wedged`; what they hold stays. In a groove or beside a step the tool rests on a bank
/// before it reaches the place that it is pressed at: sound rows stand up to 30 degrees off, wedged
/// ones 57 to 71, and their stated errors do not hold. Drags and paths are left as they are, for a
/// force across is what they are made for.
void mark_wedged(const Vec3& normal, SampleRows& rows);

/// Gives rows of second tools the status, checks and error of their first ones, with which they
/// were solved.
void complete_second_tools(SampleRows& rows);

}  // namespace palpate::fem
