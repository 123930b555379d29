#include "libfem/solve/experiments/simulator.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libfem/materials/relaxation.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/experiments/base_refinement.hpp"
#include "libfem/solve/experiments/experiment_plan.hpp"
#include "libfem/solve/experiments/held_depths.hpp"
#include "libfem/solve/experiments/loaded_shape.hpp"
#include "libfem/solve/experiments/mesh_transfer.hpp"
#include "libfem/solve/experiments/record_rows.hpp"
#include "libfem/solve/experiments/richardson.hpp"
#include "libfem/solve/experiments/surface_places.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

/// Element size at the edge of a punch, over the edge's radius and element_size. Pressure is all
/// but singular there, and sizes grow from the edge on. Chosen on layers of 4 to 10 punch radii:
/// 0.3 leaves errors of up to 0.8 % of the extrapolated force, all within their bounds. 0.4 leaves
/// up to 1.8 % in rows that claim 1.3 %. So does one size below the whole punch
/// (tests/validation/contact).
constexpr double kEdgeShare = 0.3;
constexpr double kBaseShare = 0.25;  // of force_tolerance: a change of compliance worth halving
constexpr double kShapeTolerance = 1e-3;  // of the shape under load, over the probe's length
constexpr int kRingPieces = 24;           // chords are within 0.01 of the radius

/// Force of a hold, relative: what is asked for and, on the coarse mesh alone, near enough to go on
/// with both. Two rounds to four do; what does not follow the model is given up.
constexpr double kHeldForce = 1e-3, kRoughForce = 1e-2;
constexpr int kMaxRounds = 12;

/// coarsening: of the sizes that the contact asks for. halved: base tets, see GradeOptions.
struct Fineness {
  double coarsening = 1;
  const std::vector<char>& halved;
};

/// Displacements of the surface are rounded to 2^-13 of the probe's length: a micrometre of 8 mm.
constexpr int kSurfaceBits = 13;

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

}  // namespace

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
  std::optional<LoadedShape> bent;  // of the base mesh, about origin; where there is weight

  /// As it leans in the plan.
  Probe probe_of(const ExperimentPlan& plan, const Vec3& normal) const {
    return tilted(probe, normal, plan.lean, "[probe]");
  }
  Vec3 scene_place(const Vec3& x) const;
  bool unbend_at(const Vec3& position, QuadraticMesh& mesh) const;
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
  PointRows experiment(const ExperimentPlan& plan, const BaseRefinement& base, const Vec3& position,
                       const Vec3& normal, const Progress& progress) const;
  PointRows hold(const ToolPath& path, const Vec3& position, const Vec3& normal,
                 const Progress& progress) const;
  PointRows quick_press(const ExperimentPlan& plan, const Vec3& position, const Vec3& normal,
                        const Progress& progress) const;
};

namespace {

std::ptrdiff_t count_solved(const std::vector<PointRow>& rows) {
  return std::count_if(rows.begin(), rows.end(),
                       [](const PointRow& row) { return is_solved(row.status); });
}

Surface moved(Surface surface, const Vec3& by) {
  surface.vertices.rowwise() += by.transpose();
  return surface;
}

Experiments without_drags(Experiments experiments) {
  experiments.drag_depths_m.clear();
  return experiments;
}

double at_first_over_slow(const std::vector<Material>& materials) {
  double most = 1;
  for (const Material& material : materials)
    most = std::max(most, instantaneous_stiffness(material.relaxation));
  return most;
}

Vec3 middle_of(const Points& points) {
  return (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose() / 2;
}

}  // namespace

Simulator::Simulator(SimulationSetup setup) {
  check_setup(setup);
  const Vec3 origin = middle_of(setup.volume.nodes);
  SmoothSurface surface(moved(setup.surface, -origin));
  auto state = std::make_unique<State>(
      State{std::move(setup), origin, {}, std::move(surface), {}, {}, {}, {}});
  state->volume = state->setup.volume;
  state->volume.nodes.rowwise() -= origin.transpose();
  for (std::size_t m = 0; m < state->setup.materials.size(); ++m)
    state->materials.push_back(make_material(
        state->setup.materials[m], m == 0 ? "[material]" : "[[inclusion]] " + std::to_string(m)));
  state->probe = make_probe(state->setup.probe, "[probe]");
  state->outward = vertex_normals(state->setup.surface);
  if (state->setup.weight.is_there()) state->bent = unbend_base(state->setup, origin);
  state_ = std::move(state);
}

Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

const SimulationSetup& Simulator::setup() const { return state_->setup; }

Mat3 Simulator::normal_gradient(const Vec3& position, const Vec3& normal) const {
  const Vec3 place = position - state_->origin;
  // The sheet that faces the probe, not the other side of a thin body.
  const std::optional<SurfaceHit> hit = state_->surface.closest(place, -normal, 0.3);
  return state_->surface.normal_gradient(hit ? *hit : state_->surface.closest(place),
                                         state_->probe.half_width_m);
}

/// The graded mesh about a test point, in coordinates whose origin is the test point. About each
/// segment of the contact, size is proportional to distance from the contact radius at its depth
/// on: so at every depth the rim of the contact meets elements of the same share of its radius.
QuadraticMesh Simulator::State::mesh_at(const Vec3& position, const Vec3& normal,
                                        const ExperimentPlan& plan,
                                        const Fineness& fineness) const {
  const SolverOptions& options = setup.options;
  const double coarsening = fineness.coarsening;
  const Probe tool = probe_of(plan, normal);
  GradeOptions grade;
  grade.halved = fineness.halved;
  if (setup.held_at)
    grade.held_at = [this](const Vec3& x, bool is_on_boundary) {
      return setup.held_at(scene_place(x), is_on_boundary);
    };
  grade.growth = options.growth * coarsening;
  grade.interface_share = options.interface_share;
  if (setup.region_at)
    grade.region_at = [this](const Vec3& x) { return setup.region_at(scene_place(x)); };
  const double ring = tool.edge_ring_m();
  const auto add_ring = [&](const Vec3& middle) {
    const std::vector<Vec3> out = drag_tangents(normal, kRingPieces);
    for (int k = 0; k < kRingPieces; ++k)
      grade.path.push_back({position - origin + middle + ring * out[k],
                            position - origin + middle + ring * out[(k + 1) % kRingPieces],
                            coarsening * options.element_size * kEdgeShare * ring, 0});
  };
  for (const ContactSegment& segment : plan.segments) {
    const double depth = std::max(segment.depth_m, options.shallowest * plan.depth_m);
    const double radius = tool.mesh_length_m(depth);
    const auto add = [&](const Vec3& from, const Vec3& to) {
      grade.path.push_back({position - origin + from, position - origin + to,
                            coarsening * options.element_size * radius,
                            tool.contact_reach_m(depth) - radius});
    };
    if (ring > 0 && segment.from == segment.to) {
      if (grade.path.empty()) add_ring(segment.from);  // a press begins every plan; once is enough
      continue;
    }
    add(segment.from, segment.to);
    const ContactLine line = tool.contact_line_m(normal, depth);
    if (line.from == line.to) continue;
    add(segment.from + line.from, segment.from + line.to);
    add(segment.to + line.from, segment.to + line.to);
  }
  QuadraticMesh mesh = grade_mesh(volume, setup.is_held, surface, grade);
  mesh.nodes.rowwise() -= (position - origin).transpose();
  return mesh;
}

/// mesh: of mesh_at for the same plan.
MeshRun Simulator::State::run(QuadraticMesh mesh, const ExperimentPlan& plan, const Vec3& position,
                              const Vec3& normal, bool keeps_surface, const Progress& progress,
                              const MeshRun* coarser) const {
  MeshRun out;
  out.nodes = static_cast<int>(mesh.nodes.rows());
  out.rows.assign(plan.rows.size(), {});
  if (!unbend_at(position, mesh)) {
    for (PathRow& row : out.rows) row.status = RowStatus::not_converged;
    return out;
  }
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const std::optional<double> touch =
      first_touch_m(mesh, here, {Vec3::Zero(), normal}, 2 * here.half_width_m, here.half_width_m);
  if (!touch) {
    for (PathRow& row : out.rows) row.status = RowStatus::no_contact;
    return out;
  }
  out.touch_m = *touch;
  ProbePose pose{out.touch_m * normal, normal};
  if (plan.second) {
    const auto& [place, axis] = *plan.second;
    const std::optional<double> touch_m =
        first_touch_m(mesh, here, {place, axis}, 2 * here.half_width_m, here.half_width_m);
    if (!touch_m) {
      for (PathRow& row : out.rows) row.status = RowStatus::no_contact;
      return out;
    }
    pose.second = {place + *touch_m * axis, axis};
  }
  ContactSettings contact = setup.options.contact;
  // The penalty is in moduli of slow motion; a body that is stiffer at first overlaps no further.
  if (plan.is_in_time) contact.stiffness *= at_first_over_slow(materials);
  Equilibrium equilibrium(mesh, materials, region_about(position), here, contact,
                          setup.options.equilibrium, bed_about(position), setup.weight);
  OnRow on_row;
  if (keeps_surface) {
    out.surface.resize(plan.rows.size());
    Points places = setup.surface.vertices;
    places.rowwise() -= position.transpose();
    const SurfacePlaces surface_places(mesh, places, outward);
    const double quantum_m = std::ldexp(1, std::ilogb(here.length_m) - kSurfaceBits);
    on_row = [&out, surface_places, quantum_m, before = mesh.displacement()](int row,
                                                                             const Points& u) {
      out.surface[static_cast<std::size_t>(row)] =
          surface_places.displacement(u - before, quantum_m);
    };
  }
  out.rows = follow_paths(
      equilibrium, here, pose, plan.paths, static_cast<int>(plan.rows.size()), setup.options.path,
      progress, on_row,
      coarser != nullptr ? transferred(coarser->reached, coarser->mesh, mesh) : Waypoints{},
      &out.reached);
  out.mesh = std::move(mesh);
  out.counts = equilibrium.counts();
  out.is_complete = !progress.stopped();
  return out;
}

// What the scene calls a place of the given shape, x about origin.
Vec3 Simulator::State::scene_place(const Vec3& x) const {
  return (bent && setup.regions_at_rest ? Vec3(x - bent->sag_at(x)) : x) + origin;
}

// The shape at rest of a graded mesh that is in the shape under load. False where there is none.
bool Simulator::State::unbend_at(const Vec3& position, QuadraticMesh& mesh) const {
  if (!bent) return true;
  const WeightedBody body{materials, region_about(position), bed_about(position),
                          setup.options.equilibrium.element, setup.weight};
  return unbend(body, kShapeTolerance * probe.length_m, bent->sag_of(mesh, position - origin), mesh)
      .is_found();
}

RegionAt Simulator::State::region_about(const Vec3& position) const {
  if (!setup.region_at) return {};
  return [this, position](const Vec3& x) {
    return setup.region_at(scene_place(x + position - origin));
  };
}

BedAt Simulator::State::bed_about(const Vec3& position) const {
  if (!setup.bed_at) return {};
  return
      [this, position](const Vec3& x) { return setup.bed_at(scene_place(x + position - origin)); };
}

/// A unit load, spread over the contact at the deepest depth.
PatchResponse Simulator::State::patch_at(QuadraticMesh mesh, const ExperimentPlan& plan,
                                         const Vec3& position, const Vec3& normal) const {
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const double reach_m = here.contact_reach_m(plan.depth_m);
  if (bent) {  // near enough for a tangent
    mesh.loaded = mesh.nodes;
    mesh.nodes -= bent->sag_of(mesh, position - origin);
  }
  return press_patch(mesh, static_cast<std::size_t>(volume.tets.rows()), materials,
                     region_about(position), setup.options.equilibrium.element, normal,
                     reach_m > 0 ? reach_m : here.half_width_m, bed_about(position));
}

/// Both grids of a point share the base mesh, so their difference tells nothing of it.
BaseRefinement Simulator::State::base_at(const ExperimentPlan& plan, const Vec3& position,
                                         const Vec3& normal) const {
  const SolverOptions& options = setup.options;
  if (!(options.max_base_change > 0 && options.coarse_ratio > 0)) return {};
  return refine_base(
      [&](const std::vector<char>& halved) {
        return patch_at(mesh_at(position, normal, plan, {options.coarse_ratio, halved}), plan,
                        position, normal);
      },
      options.force_tolerance > 0
          ? std::min(options.max_base_change, kBaseShare * options.force_tolerance)
          : options.max_base_change);
}

/// Whether another material than that at the test point is so close that its border matters: on a
/// grid of half contact radii, two of them about the point.
bool Simulator::State::sees_interface(const Vec3& position, const Probe& here,
                                      double depth_m) const {
  if (!setup.region_at) return false;
  constexpr int kReach = 4;  // of half radii
  const double step = here.contact_reach_m(depth_m) / 2;
  const RegionAt region_at = region_about(position);
  const int own = region_at(Vec3::Zero());
  for (int i = -kReach; i <= kReach; ++i)
    for (int j = -kReach; j <= kReach; ++j)
      for (int k = -kReach; k <= kReach; ++k)
        if (region_at(step * Vec3(i, j, k)) != own) return true;
  return false;
}

PointRows Simulator::State::experiment(const ExperimentPlan& plan, const BaseRefinement& base,
                                       const Vec3& position, const Vec3& normal,
                                       const Progress& progress) const {
  const double ratio = setup.options.coarse_ratio;
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const double min_error =
      sees_interface(position, here, plan.depth_m) ? kMinErrorAtBorder : kMinError;
  const auto recorded = [&](const MeshRun& fine, const MeshRun& coarse) {
    PointRows out;
    out.is_complete = fine.is_complete && coarse.is_complete;
    out.touch_offset_m = fine.touch_m;
    out.cost = {fine.nodes, coarse.nodes, fine.counts, coarse.counts};
    out.rows = plan.rows;
    record_rows(fine.rows, coarse.rows, ratio, min_error, out.rows);
    mark_wedged(normal, out.rows);
    for (PointRow& row : out.rows) {
      row.force_error += base.error * row.force.norm();
      if (plan.is_in_time) row.force_error += kStepError * row.force.norm();
      row.sway_m_N = base.sway_m_N;
    }
    for (std::size_t row = 0; row < fine.surface.size(); ++row)
      if (out.rows[row].status == RowStatus::good) out.rows[row].surface = fine.surface[row];
    return out;
  };
  const auto run_at = [&](double coarsening, bool keeps_surface, const MeshRun* coarser) {
    return run(mesh_at(position, normal, plan, {coarsening, base.halved}), plan, position, normal,
               keeps_surface, progress, coarser);
  };
  MeshRun fine, coarse;
  if (ratio > 0) coarse = run_at(ratio, false, nullptr);
  fine = run_at(1, setup.keeps_surface, ratio > 0 ? &coarse : nullptr);
  PointRows out = recorded(fine, coarse);
  double coarsening = 1;
  for (int finer = 0; finer < kMaxFiner && out.is_complete && ratio > 0; ++finer) {
    // Where the base mesh alone is worse, its grids need not be better than half of what is asked.
    const double wanted = setup.options.force_tolerance;
    if (!(wanted > 0 &&
          achieved_error(out.rows) - base.error > std::max(wanted - base.error, wanted / 2)))
      break;
    coarse = std::move(fine);
    coarsening /= ratio;
    fine = run_at(coarsening, setup.keeps_surface, &coarse);
    PointRows next = recorded(fine, coarse);
    if (count_solved(next.rows) < count_solved(out.rows) && next.is_complete)
      break;  // what solved is not given up
    out = std::move(next);
  }
  return out;
}

// All forces of a path are sought together, on meshes that stay: so what is asked for is the force
// that rows have, extrapolated, and a row is what the path of its depths gives.
PointRows Simulator::State::hold(const ToolPath& path, const Vec3& position, const Vec3& normal,
                                 const Progress& progress) const {
  ExperimentPlan plan = path_plan(path, position, normal);
  const BaseRefinement base = base_at(plan, position, normal);
  const double ratio = setup.options.coarse_ratio;
  HeldDepths depths(path, normal, materials.front().relaxation);
  for (int round = 0; round < kMaxRounds && ratio > 0; ++round) {
    depths.place(plan);
    const MeshRun coarse = run(mesh_at(position, normal, plan, {ratio, base.halved}), plan,
                               position, normal, false, progress);
    if (!coarse.is_complete) return {};
    std::vector<PointRow> rows = plan.rows;
    record_rows(coarse.rows, {}, 0, 0, rows);
    if (depths.is_over(rows, kRoughForce)) break;
    depths.learn(rows);
  }
  PointRows out;
  for (int round = 0; round < kMaxRounds; ++round) {
    depths.place(plan);
    out = experiment(plan, base, position, normal, progress);
    if (!out.is_complete || depths.is_over(out.rows, kHeldForce)) break;
    depths.learn(out.rows);
  }
  if (!out.is_complete) return out;
  // What was not found is no hold, nor is what follows.
  const auto unmet = static_cast<std::size_t>(depths.first_unmet(out.rows, kHeldForce));
  for (std::size_t i = unmet; i < out.rows.size(); ++i) {
    const PointRow& solved = out.rows[i];
    const RowStatus status = i > unmet                          ? RowStatus::not_reached
                             : solved.status == RowStatus::good ? RowStatus::not_converged
                                                                : solved.status;
    out.rows[i] = plan.rows[i];
    out.rows[i].sway_m_N = solved.sway_m_N;
    out.rows[i].status = status;
  }
  return out;
}

PointRows Simulator::press_and_drag(const Vec3& position, const Vec3& normal,
                                    const Experiments& experiments,
                                    const Progress& progress) const {
  const ExperimentPlan plan = press_and_drag_plan(experiments, normal);
  return state_->experiment(plan, state_->base_at(plan, position, normal), position, normal,
                            progress);
}

PointRows Simulator::State::quick_press(const ExperimentPlan& plan, const Vec3& position,
                                        const Vec3& normal, const Progress& progress) const {
  const std::vector<char> none_halved;
  const double ratio = setup.options.coarse_ratio;
  const QuadraticMesh mesh = mesh_at(position, normal, plan, {ratio > 0 ? ratio : 1, none_halved});
  const MeshRun run = this->run(mesh, plan, position, normal, setup.keeps_surface, progress);
  PointRows out;
  out.is_complete = run.is_complete;
  out.touch_offset_m = run.touch_m;
  out.cost = {run.nodes, 0, run.counts, {}};
  out.rows = plan.rows;
  if (!run.is_complete) return out;
  const Mat3 sway = patch_at(mesh, plan, position, normal).sway_m_N;
  for (std::size_t i = 0; i < out.rows.size(); ++i) {
    const PathRow& solved = run.rows[i];
    PointRow& row = out.rows[i];
    row.status = solved.status;
    row.step_check = solved.step_check;
    row.sway_m_N = sway;
    if (solved.status != RowStatus::good) continue;
    row.force = solved.force_N;
    row.torque = solved.torque_Nm;
    row.force_error = solved.penalty_error_N + solved.solver_error_N;
    if (!run.surface.empty()) row.surface = run.surface[i];
  }
  mark_wedged(normal, out.rows);
  return out;
}

PointRows Simulator::press_quickly(const Vec3& position, const Vec3& normal,
                                   const Experiments& experiments, const Progress& progress) const {
  return state_->quick_press(press_and_drag_plan(without_drags(experiments), normal), position,
                             normal, progress);
}

PointRows Simulator::press_at_once(const Vec3& position, const Vec3& normal,
                                   const Experiments& experiments, const Progress& progress) const {
  return state_->quick_press(at_once(press_and_drag_plan(without_drags(experiments), normal)),
                             position, normal, progress);
}

PointRows Simulator::follow(const Vec3& position, const Vec3& normal, const ToolPath& path,
                            const Progress& progress) const {
  if (path.held_N.array().isFinite().any()) return state_->hold(path, position, normal, progress);
  const ExperimentPlan plan = path_plan(path, position, normal);
  return state_->experiment(plan, state_->base_at(plan, position, normal), position, normal,
                            progress);
}

}  // namespace palpate::fem
