#include "libfem/solve/experiments/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator_state.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"

namespace palpate::fem {
namespace {

std::ptrdiff_t count_solved(const SampleRows& rows) {
  return std::ranges::count_if(rows.status, is_solved);
}

Surface moved(Surface surface, const Vec3& by) {
  surface.vertices.rowwise() += by.transpose();
  return surface;
}

Experiments without_drags(Experiments experiments) {
  experiments.drag_depths_m.clear();
  return experiments;
}

bool is_straight(const ExperimentPlan& path) {
  return std::ranges::all_of(path.segments, [&](const ContactSegment& segment) {
    return segment.to.norm() <= 1e-9 * path.depth_m;
  });
}

// Relative error of a force (M13c): to first order a mesh off the surface presses deeper by the
// mean of what it is off over the contact, and force goes as depth^(3/2).
double bump_error(const QuadraticMesh& mesh, double depth_m) {
  return 1.5 * mesh.contact_deviation_m / depth_m;
}

// The motion of the surface in good rows, of each on the finer mesh that has it.
void keep_surface(const std::vector<Eigen::VectorXf>& fine,
                  const std::vector<Eigen::VectorXf>& coarse, SampleRows& out) {
  for (std::size_t row = 0; row < fine.size(); ++row) {
    if (out.status[row] != RowStatus::good) continue;
    const Eigen::VectorXf& moved = fine[row].size() > 0 ? fine[row] : coarse[row];
    if (out.surface.rows() == 0) out.surface.setZero(out.rows(), moved.size());
    out.surface.row(row) = moved;
  }
}

Vec3 middle_of(const Points& points) {
  return (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose() / 2;
}

void need(bool is_so, const char* where, const std::string& what, const std::string& remedy) {
  if (!is_so) throw Error(where, what, remedy);
}

/// Thickness [m] of the body from a surface point along the inward normal, of a hollow part as far
/// as its wall can go before it meets the wall across the lumen; +inf where the ray meets no second
/// sheet.
double thickness_m(const Surface& surface, const Vec3& position, const Vec3& normal,
                   double skip_m) {
  const std::vector<char> is_lumen = faces_of_lumens(surface.vertices, surface.triangles);
  std::vector<std::pair<double, bool>> hits;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    const double hit = ray_hit_m(position, normal, a, b, c);
    if (hit > skip_m && std::isfinite(hit)) hits.emplace_back(hit, is_lumen[f] != 0);
  }
  std::ranges::sort(hits);
  if (hits.empty()) return std::numeric_limits<double>::infinity();
  return hits.front().second && hits.size() > 1 ? hits[1].first - hits.front().first
                                                : hits.front().first;
}

// One sliver in a hundred changes no force by more than the rows' error; a mesh of which every
// inner node makes slivers was 8 to 15 % too stiff in rows that claimed 2
// (tests/validation/hard_cases_test).
constexpr double kFlatDeg = 2;

/// Share of the tets of which two faces meet at less than kFlatDeg.
double flat_share(const TetMesh& mesh) {
  Eigen::Index flat = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    flat += min_dihedral_deg(corners_of(mesh, t)) < kFlatDeg;
  return static_cast<double>(flat) / static_cast<double>(mesh.tets.rows());
}

/// Materials and probe that a setup names.
struct SetupParts {
  std::vector<Material> materials;
  Probe probe;
};

SetupParts checked_parts(const SimulationSetup& setup) {
  need(setup.volume.tets.rows() > 0, "[body]", "the body has no volume mesh",
       "Prepare it without --surface-only.");
  need(setup.volume.nodes.allFinite(), "[body]", "a node of the volume is not finite",
       "Prepare the body again.");
  need(setup.is_held.size() == static_cast<std::size_t>(setup.volume.nodes.rows()), "[body] fixed",
       "held flags do not match the nodes of the volume", "Prepare the body again.");
  need(
      flat_share(setup.volume) <= 0.05, "[body]",
      "more than one tetrahedron in twenty is flatter than 2 degrees, which makes a body too stiff",
      "Give the surface alone, so that it is filled anew, or a better mesh.");
  const auto held = std::count(setup.is_held.begin(), setup.is_held.end(), char(1));
  need(held >= 3 || setup.loads.bed_at, "[body] fixed",
       held == 0 ? "no node is held, so a press would push the body away"
                 : "fewer than three nodes are held, so a press would turn the body about them",
       "Give `fixed` a region that holds part of the body, such as the face it lies on.");
  need(!setup.materials.empty(), "[material]", "no material is given",
       "Name a law and its parameters.");
  SetupParts out;
  for (std::size_t m = 0; m < setup.materials.size(); ++m)
    out.materials.push_back(make_material(
        setup.materials[m], m == 0 ? "[material]" : "[[inclusion]] " + std::to_string(m)));
  out.probe = make_probe(setup.probe, "[probe]");
  const double largest_m = extent_m(setup.volume.nodes).maxCoeff();
  need(2 * out.probe.half_width_m <= largest_m, "[probe]",
       "the probe (" + millimetres(2 * out.probe.half_width_m) +
           " wide) is larger than the body (" + millimetres(largest_m) + ")",
       "Check length_unit and the size of the probe.");
  return out;
}

}  // namespace

Simulator::Simulator(SimulationSetup setup) {
  SetupParts parts = checked_parts(setup);
  const Vec3 origin = middle_of(setup.volume.nodes);
  SmoothSurface surface(moved(setup.surface, -origin));
  TetMesh volume = setup.volume;
  volume.nodes.rowwise() -= origin.transpose();
  Points outward = vertex_normals(setup.surface);
  state_ = std::make_unique<const State>(State{std::move(setup), origin, std::move(volume),
                                               std::move(surface), std::move(parts.materials),
                                               std::move(parts.probe), std::move(outward)});
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

// Rows beside the press are then taken from the coarse grid (M13k).
bool Simulator::State::is_told_by_press(const ExperimentPlan& plan) const {
  return plan.paths.size() > 1 && setup.options.coarse_ratio > 0 &&
         setup.options.force_tolerance == 0;
}

ExperimentPlan Simulator::State::fine_part(const ExperimentPlan& plan) const {
  ExperimentPlan out = plan;
  if (is_told_by_press(plan)) out.paths.resize(1);
  return out;
}

PointRows Simulator::State::experiment(const ExperimentPlan& plan, const BaseRefinement& base,
                                       const Vec3& position, const Vec3& normal,
                                       const Progress& progress) const {
  const double ratio = setup.options.coarse_ratio;
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const double min_error =
      sees_interface(position, here, plan.depth_m) ? kMinErrorAtBorder : kMinError;
  const bool is_by_press = is_told_by_press(plan);
  const ExperimentPlan on_fine = fine_part(plan);
  const auto recorded = [&](const MeshRun& fine, const MeshRun& coarse) {
    PointRows out{plan.rows, sway_in_press(fine, plan, normal, base.sway_m_N)};
    out.is_complete = fine.is_complete && coarse.is_complete;
    out.cost = {static_cast<int>(fine.mesh.nodes.rows()),
                static_cast<int>(coarse.mesh.nodes.rows()), fine.counts};
    if (!plan.lean.isZero(0)) out.lean = plan.lean.transpose().replicate(out.rows(), 1);
    record_rows(fine.rows, coarse.rows, ratio, min_error, out);
    if (is_by_press) record_by_press(coarse.rows, out);
    mark_wedged(normal, out);
    for (Eigen::Index row = 0; row < out.rows(); ++row) {
      const double force_N = out.force.row(row).norm(), of_step = plan.is_in_time ? kStepError : 0;
      out.force_error[row] =
          std::hypot(std::hypot(out.force_error[row], of_step * force_N), base.error * force_N,
                     bump_error(fine.mesh, plan.depth_m) * force_N);
    }
    keep_surface(fine.surface, coarse.surface, out);
    return out;
  };
  const auto run_at = [&](double coarsening, const ExperimentPlan& of, bool keeps_surface,
                          const MeshRun* coarser) {
    return run(mesh_at(position, normal, of, {coarsening, base.halved}), of, position, normal,
               keeps_surface, progress, coarser);
  };
  MeshRun fine, coarse;
  if (ratio > 0) coarse = run_at(ratio, plan, is_by_press && setup.keeps_surface, nullptr);
  fine = run_at(1, on_fine, setup.keeps_surface, ratio > 0 ? &coarse : nullptr);
  PointRows out = recorded(fine, coarse);
  double coarsening = 1;
  // A finer mesh has two to four times the nodes of the one before and about eight times its work.
  for (int finer = 0; finer < 2 && out.is_complete && ratio > 0; ++finer) {
    // If the base mesh alone is worse, its grids need not be better than half of what is asked.
    const double wanted = setup.options.force_tolerance, achieved = achieved_error(out);
    if (!(wanted > 0 && achieved > std::max(wanted, std::hypot(base.error, wanted / 2)))) break;
    const double finer_by = coarsening / ratio;
    QuadraticMesh finer_mesh = mesh_at(position, normal, plan, {finer_by, base.halved});
    // Share of a force: a mesh whose distance from the surface changes it by more has a bump under
    // the tool.
    if (bump_error(finer_mesh, plan.depth_m) > 0.01) break;  // the surface is not given up
    coarse = std::move(fine);
    coarsening = finer_by;
    fine =
        run(std::move(finer_mesh), plan, position, normal, setup.keeps_surface, progress, &coarse);
    PointRows next = recorded(fine, coarse);
    if (count_solved(next) < count_solved(out) && next.is_complete)
      break;  // what solved is not given up
    out = std::move(next);
  }
  complete_second_tools(out);
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
  const MeshRun run =
      this->run(mesh_at(position, normal, plan, {ratio > 0 ? ratio : 1, none_halved}), plan,
                position, normal, setup.keeps_surface, progress);
  PointRows out{plan.rows};
  out.is_complete = run.is_complete;
  out.cost = {static_cast<int>(run.mesh.nodes.rows()), 0, run.counts};
  if (!run.is_complete) return out;
  out.sway_m_N =
      sway_in_press(run, plan, normal, patch_at(run.mesh, plan, position, normal).sway_m_N);
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const PathRow& solved = run.rows[i];
    if (!write_row(solved, 1, i, out)) continue;
    out.force_error[i] = std::hypot(solved.penalty_error_N, solved.solver_error_N,
                                    bump_error(run.mesh, plan.depth_m) * solved.force_N.norm());
  }
  keep_surface(run.surface, {}, out);
  mark_wedged(normal, out);
  return out;
}

PointRows Simulator::press_quickly(const Vec3& position, const Vec3& normal,
                                   const Experiments& experiments, const Progress& progress) const {
  return state_->quick_press(press_and_drag_plan(without_drags(experiments), normal), position,
                             normal, progress);
}

double Simulator::held_share(const Vec3& position, const Vec3& normal,
                             const Experiments& experiments, const Progress& progress) const {
  SimulationSetup looser = state_->setup;
  std::vector<double> distance_m;
  for (Eigen::Index n = 0; n < looser.volume.nodes.rows(); ++n)
    if (looser.is_held[n])
      distance_m.push_back((looser.volume.nodes.row(n).transpose() - position).norm());
  if (distance_m.size() < 6) return 0;
  const double half_m = median(distance_m);
  const auto is_far = [=](const Vec3& x) { return (x - position).norm() >= half_m; };
  for (Eigen::Index n = 0; n < looser.volume.nodes.rows(); ++n)
    if (!is_far(looser.volume.nodes.row(n))) looser.is_held[n] = 0;
  if (looser.held_at)
    looser.held_at = [is_far, held_at = looser.held_at](const Vec3& x, bool is_on_boundary) {
      return is_far(x) && held_at(x, is_on_boundary);
    };
  const auto end_N = [&](const Simulator& of) {
    const PointRows press = of.press_quickly(position, normal, experiments, progress);
    double deepest_m = 0, out = 0;
    for (Eigen::Index row = 0; row < press.rows(); ++row)
      if (const double depth_m = press.deflection.row(row).dot(normal);
          press.status[row] == RowStatus::good && depth_m > deepest_m) {
        deepest_m = depth_m;
        out = press.force.row(row).dot(normal);
      }
    return out;
  };
  const double held_N = end_N(*this), looser_N = end_N(Simulator(std::move(looser)));
  return held_N > 0 && looser_N > 0 ? std::max(0.0, 1 - looser_N / held_N) : 0;
}

PointRows Simulator::press_at_once(const Vec3& position, const Vec3& normal,
                                   const Experiments& experiments, const Progress& progress) const {
  ExperimentPlan plan = press_and_drag_plan(without_drags(experiments), normal);
  plan.is_in_time = true;
  for (PathTarget& target : plan.paths.front().targets) target.time_s = 0;
  return state_->quick_press(plan, position, normal, progress);
}

PointRows Simulator::follow(const Vec3& position, const Vec3& normal, const ToolPath& path,
                            const Progress& progress) const {
  const ExperimentPlan plan = path_plan(path, position, normal);
  const auto simulated = [&](const ExperimentPlan& of) {
    return state_->experiment(of, state_->base_at(of, position, normal), position, normal,
                              progress);
  };
  if (plan.second || plan.is_in_time || is_straight(plan)) return simulated(plan);
  const ExperimentPlan with = with_press(plan, normal);
  if (!state_->is_told_by_press(with)) return simulated(plan);
  PointRows out = simulated(with);
  const auto press = out.status.begin() + plan.rows.rows();
  const auto is_good = [](RowStatus status) { return status == RowStatus::good; };
  const auto is_followed = [&](RowStatus status) {
    return is_good(status) || status == RowStatus::no_contact;
  };
  const bool is_told = std::all_of(out.status.begin(), press, is_followed) &&
                       std::all_of(press, out.status.end(), is_good);
  if (out.is_complete && !is_told) return simulated(plan);
  std::vector<Eigen::Index> of_path(plan.rows.rows());
  std::iota(of_path.begin(), of_path.end(), Eigen::Index{0});
  SampleRows kept;
  append_rows(kept, out, of_path);
  static_cast<SampleRows&>(out) = std::move(kept);
  return out;
}

void check_setup(const SimulationSetup& setup) { checked_parts(setup); }

void check_experiments(const SimulationSetup& setup, const Experiments& experiments,
                       const Vec3& position, const Vec3& normal) {
  const char* where = "[experiments]";
  need(std::isfinite(experiments.depth_m) && experiments.depth_m > 0, where,
       "depth must be positive", "Give the deepest press with its unit.");
  need(experiments.press_steps >= 1, where, "press_steps must be 1 or more", "Use about 10.");
  need(position.allFinite() && std::abs(normal.norm() - 1) < 1e-6, where,
       "a test point has no position or no unit normal", "Prepare the body again.");
  for (const double depth : experiments.drag_depths_m)
    need(depth > 0 && depth <= experiments.depth_m * (1 + 1e-9), where,
         "drag depth " + millimetres(depth) + " is not within the press (" +
             millimetres(experiments.depth_m) + ")",
         "Keep drag_depths between 0 and depth.");
  if (!experiments.drag_depths_m.empty())
    need(experiments.drag_distance_m > 0 && experiments.drag_directions >= 1 &&
             experiments.drag_steps >= 1,
         where, "drags need a positive drag_distance, directions and steps",
         "Give them, or leave drag_depths empty for presses only.");
  const double thick = thickness_m(setup.surface, position, normal, 1e-6 * experiments.depth_m);
  need(experiments.depth_m < thick, where,
       "depth " + millimetres(experiments.depth_m) +
           " is more than the body is thick, or its lumen wide (" + millimetres(thick) +
           ") at a test point",
       "Press less deep, or restrict the region of test points.");
}

}  // namespace palpate::fem
