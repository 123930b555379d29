#pragma once

#include <optional>
#include <vector>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/experiments/base_refinement.hpp"
#include "libfem/solve/experiments/experiment_plan.hpp"
#include "libfem/solve/experiments/mesh_transfer.hpp"
#include "libfem/solve/experiments/simulator.hpp"

// What a simulator holds, and a plan followed on one of its meshes.

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

}  // namespace palpate::fem
