#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "libfem/solve/equilibrium/path_follower.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Displacements by which the paths on one mesh moved its nodes, from before the probe touched, at
/// the nodes of another of the same body. A node takes those of the nearest tet, as its ten shape
/// functions between straight edges have them; held nodes stay.
Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from, const QuadraticMesh& to);

/// Places of a surface on the boundary of a solved mesh, so that they move as it does.
/// A place belongs to the nearest boundary face that faces its way (each face as four flat
/// triangles between its six nodes), and moves by the face's own shape functions: at a node by
/// exactly what the node moves.
class SurfacePlaces {
 public:
  /// places, outward: S x 3 [m], unit normals, in the mesh's coordinates.
  SurfacePlaces(const QuadraticMesh& mesh, const Points& places, const Points& outward);

  /// Displacement [m] of the places where the mesh's nodes (N x 3) move by u: x, y, z of each in
  /// turn, rounded to multiples of quantum_m, a power of two: files of round numbers compress well.
  Eigen::VectorXf displacement(const Points& u, double quantum_m) const;

 private:
  struct FacePlace {
    std::array<std::int32_t, kFaceNodes> node;
    std::array<double, kFaceNodes> shape;
  };
  std::vector<FacePlace> places_;
};

/// Linear response of a body at rest to a unit force along `normal` (inward, unit) on a patch
/// of its surface. The force is spread as Hertz's pressure over faces within `radius_m` of the
/// origin that look against `normal`; compliance_m_N is the mean of the displacement, weighted
/// alike, under a unit force along each axis (a column each). distortion_J_N2: #base tets, the
/// deviatoric energy of their parts by the displacements of corners. sway_m_N: how the body moves
/// as a whole around the patch under a unit force along each axis (M33), symmetric and nowhere
/// negative; zero where that is not told. Zero and empty where no face is met or the body has no
/// stiffness.
struct PatchResponse {
  Mat3 compliance_m_N = Mat3::Zero();
  std::vector<double> distortion_J_N2;
  Mat3 sway_m_N = Mat3::Zero();
};

/// One factorization. The mesh knows its base tets (QuadraticMesh::base), `base_tets` of them.
PatchResponse press_patch(const QuadraticMesh& mesh, std::size_t base_tets,
                          const std::vector<Material>& materials, const RegionAt& region_at,
                          const Vec3& normal, double radius_m, const BoundaryLoads& loads = {});

/// Which tets of the base mesh to halve for a contact, and which share of force may be wrong after
/// that because of the base mesh: thickness, far geometry, the border of what is held.
/// halved: #base tets, or empty for none.
struct BaseRefinement {
  std::vector<char> halved;
  double error = 0;
  Mat3 sway_m_N = Mat3::Zero();  ///< of PatchResponse, on the finer mesh
};

/// The patch response on the mesh graded for the contact, its elements `coarsening` times as large
/// as the contact asks for, with these base tets halved.
using PressPatch = std::function<PatchResponse(double coarsening, const std::vector<char>& halved)>;

/// Which base tets to halve so that no more than about `max_error` of force, relative and sideways
/// too, is wrong because of the base mesh: those that hold two thirds of the distortion under
/// the patch, or none (M13d). The forces that move the patch along `normal`, sticking and sliding,
/// are compared with whole and with halved tets, on the grid whose elements are `coarse_ratio`
/// times as large; where that cannot tell, as its own error changes with the tets too, on both
/// grids, extrapolated.
BaseRefinement refine_base(const PressPatch& press, double coarse_ratio, const Vec3& normal,
                           double max_error);

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
  /// Appends the segments of a path of successive deflections of a tool, whose first touch lies at
  /// `from`, and notes how deep they go.
  void add_segments(const Points& deflections, const Vec3& from, const Vec3& normal);
};

/// The press passes every row and every depth where a drag starts; drags branch off there.
ExperimentPlan press_and_drag_plan(const Experiments& experiments, const Vec3& normal);

/// One experiment `path` along successive deflections from first touch, of both tools where there
/// are two.
ExperimentPlan path_plan(const ToolPath& path, const Vec3& position, const Vec3& normal);

/// A path with a straight press as deep beside it, path 0 of the plan; its few rows come last, as
/// experiment 1.
ExperimentPlan with_press(const ExperimentPlan& path, const Vec3& normal);

/// coarsening: of the sizes that the contact asks for. halved: base tets, see GradeOptions.
struct Fineness {
  double coarsening = 1;
  const std::vector<char>& halved;
};

/// A plan followed on one mesh.
struct MeshRun {
  std::vector<PathRow> rows;
  std::vector<Eigen::VectorXf> surface;  ///< of each row, where it is kept
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
  BoundaryLoads loads_about(const Vec3& position) const;
  double reach_m(const ExperimentPlan& plan, const Vec3& normal) const;  // of the contact, deepest
  /// The sway at rest times the share of it by which the ring moved in the plan's press (M33a):
  /// fibres that carry tension alone do not resist at rest, and thin bodies stiffen.
  Mat3 sway_in_press(const MeshRun& run, const ExperimentPlan& plan, const Vec3& normal,
                     const Mat3& at_rest) const;
  PatchResponse patch_at(QuadraticMesh mesh, const ExperimentPlan& plan, const Vec3& position,
                         const Vec3& normal) const;
  BaseRefinement base_at(const ExperimentPlan& plan, const Vec3& position,
                         const Vec3& normal) const;
  MeshRun run(QuadraticMesh finished, const ExperimentPlan& plan, const Vec3& position,
              const Vec3& normal, bool keeps_surface, const Progress& progress,
              const MeshRun* coarser = nullptr) const;
  bool sees_interface(const Vec3& position, const Probe& here, double depth_m) const;
  bool is_told_by_press(const ExperimentPlan& plan) const;  // the rest on the coarse grid alone
  /// What is solved on both grids: all, or path 0 alone, a press, on meshes of the whole plan, so
  /// that grids differ in nothing but size. All rows stay, those of other paths are never reached.
  ExperimentPlan fine_part(const ExperimentPlan& plan) const;
  PointRows experiment(const ExperimentPlan& plan, const BaseRefinement& base, const Vec3& position,
                       const Vec3& normal, const Progress& progress) const;
  PointRows quick_press(const ExperimentPlan& plan, const Vec3& position, const Vec3& normal,
                        const Progress& progress) const;
};

/// Writes what was solved at row i, force and torque times a factor; false where it is not good.
bool write_row(const PathRow& solved, double factor, Eigen::Index i, SampleRows& out);

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

/// Comparison of a mesh with a coarse grid by the forces of one experiment, all relative to them.
/// excess: by how much forces on the mesh exceed those of an ever finer one, to be taken off.
/// error: of what is then left, per row, at 95 %; NaN where nothing can be compared.
struct Richardson {
  double excess = 0;
  std::vector<double> error;
};

/// Errors that grids which agree have in common: forces of balls and cones on exact layers are up
/// to 1.1 % off (tests/validation/contact), and 1.2 % where the border of another material, whose
/// elements differ from it, is within two contact radii (soft and stiff lumps: tests/libfem/solve).
inline constexpr double kMinError = 0.01, kMinErrorAtBorder = 0.012;

/// Richardson extrapolation to elements of size zero of the rows of one experiment. fine, coarse:
/// forces [N] on the mesh and on a coarse grid whose elements are `ratio` times as large; zero
/// where a row failed. A mesh with size proportional to distance from first touch is too stiff by
/// nearly the same share at every depth, while differences of single rows scatter with how the rim
/// of the contact happens to cut elements: so excess is the mean of all rows, and a row's own
/// deviation from it, sideways too, only adds to its error, in quadrature to half of the excess
/// (M13b, M13c). Forces below a hundredth of the largest do not count for the mean. No
/// extrapolation where the coarse grid is off by more than a tenth: the error is then all of the
/// difference. min_error: no error is below it. Source: Richardson 1911,
/// doi:10.1098/rsta.1911.0009, with the order observed, 2.
Richardson richardson(const std::vector<Vec3>& fine, const std::vector<Vec3>& coarse, double ratio,
                      double min_error = kMinError);

}  // namespace palpate::fem
