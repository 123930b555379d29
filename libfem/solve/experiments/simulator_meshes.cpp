// A plan on one mesh: the mesh graded for it, what of the body is where, and the solution.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator_state.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::fem {
namespace {

/// Element size at the edge of a punch, over the edge's radius and element_size. Pressure is all
/// but singular there, and sizes grow from the edge on. Chosen on layers of 4 to 10 punch radii:
/// 0.3 leaves errors of up to 0.8 % of the extrapolated force, all within their bounds. 0.4 leaves
/// up to 1.8 % in rows that claim 1.3 %. So does one size below the whole punch
/// (tests/validation/contact).
constexpr double kEdgeShare = 0.3;
constexpr int kRingPieces = 24;  // chords are within 0.01 of the radius

// Area coordinates of corners 1 and 2 at a face's nodes, and its four flat triangles.
constexpr double kNodeR[kFaceNodes] = {0, 1, 0, 0.5, 0.5, 0};
constexpr double kNodeS[kFaceNodes] = {0, 0, 1, 0, 0.5, 0.5};
constexpr int kQuarter[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};

}  // namespace

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
      return setup.held_at(x + origin, is_on_boundary);
    };
  grade.growth = options.growth * coarsening;
  grade.interface_share = options.interface_share;
  grade.interface_size_m =
      grade.growth * options.interface_reach * tool.mesh_length_m(plan.depth_m);
  if (setup.region_at)
    grade.region_at = [this](const Vec3& x) { return setup.region_at(x + origin); };
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

/// finished: of mesh_at for the same plan.
MeshRun Simulator::State::run(QuadraticMesh finished, const ExperimentPlan& plan,
                              const Vec3& position, const Vec3& normal, bool keeps_surface,
                              const Progress& progress, const MeshRun* coarser) const {
  MeshRun out;
  out.mesh = std::move(finished);
  const QuadraticMesh& mesh = out.mesh;
  out.rows.assign(plan.rows.rows(), {});
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const auto touch_m = [&](const Vec3& place, const Vec3& axis) {
    return first_touch_m(mesh, here, {place, axis}, here.half_width_m);
  };
  const std::optional<double> first_m = touch_m(Vec3::Zero(), normal),
                              second_m = plan.second && first_m ? touch_m(plan.second->from_first_m,
                                                                          plan.second->normal)
                                                                : first_m;
  if (!second_m) {
    for (PathRow& row : out.rows) row.status = RowStatus::no_contact;
    return out;
  }
  ProbePose pose{*first_m * normal, normal};
  if (plan.second)
    pose.second = {plan.second->from_first_m + *second_m * plan.second->normal,
                   plan.second->normal};
  ContactSettings contact = setup.options.contact;
  // The penalty is in moduli of slow motion; a body that is stiffer at first overlaps no further.
  double at_first_over_slow = 1;
  for (const Material& material : materials)
    at_first_over_slow = std::max(at_first_over_slow, instantaneous_stiffness(material.relaxation));
  if (plan.is_in_time) contact.stiffness *= at_first_over_slow;
  Equilibrium equilibrium(mesh, materials, region_about(position), here, contact,
                          setup.options.equilibrium, loads_about(position));
  OnRow on_row;
  if (keeps_surface) {
    out.surface.resize(plan.rows.rows());
    Points places = setup.surface.vertices;
    places.rowwise() -= position.transpose();
    const SurfacePlaces surface_places(mesh, places, outward);
    // Displacements of the surface are rounded to 2^-13 of the probe's length: a micrometre of 8
    // mm.
    const double quantum_m = std::ldexp(1, std::ilogb(here.length_m) - 13);
    on_row = [&out, surface_places, quantum_m](int row, const Points& u) {
      out.surface[row] = surface_places.displacement(u, quantum_m);
    };
  }
  out.rows = follow_paths(
      equilibrium, here, pose, plan.paths, static_cast<int>(plan.rows.rows()),
      setup.options.uzawa_update, progress, on_row,
      coarser != nullptr ? transferred(coarser->reached, coarser->mesh, mesh) : Waypoints{},
      &out.reached);
  out.counts = equilibrium.counts();
  out.is_complete = !progress.stopped();
  return out;
}

RegionAt Simulator::State::region_about(const Vec3& position) const {
  if (!setup.region_at) return {};
  return [this, position](const Vec3& x) { return setup.region_at(x + position); };
}

BoundaryLoads Simulator::State::loads_about(const Vec3& position) const {
  BoundaryLoads out{{}, setup.loads.lumen_pressure_Pa};
  if (setup.loads.bed_at)
    out.bed_at = [this, position](const Vec3& x) { return setup.loads.bed_at(x + position); };
  return out;
}

double Simulator::State::reach_m(const ExperimentPlan& plan, const Vec3& normal) const {
  const Probe here = pressed_to(probe_of(plan, normal), plan.depth_m);
  const double by_depth_m = here.contact_reach_m(plan.depth_m);
  return by_depth_m > 0 ? by_depth_m : here.half_width_m;
}

/// A unit load, spread over the contact at the deepest depth.
PatchResponse Simulator::State::patch_at(QuadraticMesh mesh, const ExperimentPlan& plan,
                                         const Vec3& position, const Vec3& normal) const {
  return press_patch(mesh, static_cast<std::size_t>(volume.tets.rows()), materials,
                     region_about(position), normal, reach_m(plan, normal), loads_about(position));
}

/// Both grids of a point share the base mesh, so their difference tells nothing of it.
BaseRefinement Simulator::State::base_at(const ExperimentPlan& plan, const Vec3& position,
                                         const Vec3& normal) const {
  const SolverOptions& options = setup.options;
  if (!(options.max_base_error > 0 && options.coarse_ratio > 0)) return {};
  const ExperimentPlan pressed = fine_part(plan);
  return refine_base(
      [&](double coarsening, const std::vector<char>& halved) {
        return patch_at(mesh_at(position, normal, pressed, {coarsening, halved}), pressed, position,
                        normal);
        // The base mesh may be wrong by half of force_tolerance.
      },
      options.coarse_ratio, normal,
      options.force_tolerance > 0 ? std::min(options.max_base_error, 0.5 * options.force_tolerance)
                                  : options.max_base_error);
}

/// True if another material than that at the test point is so close that its border matters: on a
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

Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from,
                      const QuadraticMesh& to) {
  if (reached.empty()) return {};
  struct NodePlace {
    std::array<std::int32_t, 10> node{};
    std::array<double, 10> shape{};  // zeros where held
  };
  std::vector<NodePlace> places(to.nodes.rows());
  const TetMesh corners{from.nodes, from.tets.leftCols<4>(), {}};
  const BoxTree boxes = boxes_of(corners.nodes, corners.tets);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (to.is_held[n]) continue;
    const auto found =
        closest_in_volume(corners, boxes, to.nodes.row(n), std::numeric_limits<double>::infinity(),
                          [](const VolumePoint&) { return true; });
    if (!found) continue;
    auto& [node, shape] = places[n];
    const Eigen::Vector4d& w = found->weight;
    for (int k = 0; k < 4; ++k) shape[k] = w[k] * (2 * w[k] - 1);
    for (int e = 0; e < 6; ++e) shape[4 + e] = 4 * w[kTetEdge[e][0]] * w[kTetEdge[e][1]];
    for (int k = 0; k < 10; ++k) node[k] = from.tets(found->tet, k);
  }
  Waypoints out = reached;
  for (std::vector<Points>& path : out)
    for (Points& u : path) {
      if (u.size() == 0) continue;
      const Points there = std::exchange(u, Points::Zero(places.size(), 3));
      for (std::size_t n = 0; n < places.size(); ++n)
        for (int k = 0; k < 10; ++k) u.row(n) += places[n].shape[k] * there.row(places[n].node[k]);
    }
  return out;
}

SurfacePlaces::SurfacePlaces(const QuadraticMesh& mesh, const Points& places,
                             const Points& outward) {
  Surface flat{mesh.nodes, Triangles(4 * mesh.faces.rows(), 3)};
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int q = 0; q < 4; ++q)
      for (int k = 0; k < 3; ++k) flat.triangles(4 * f + q, k) = mesh.faces(f, kQuarter[q][k]);
  const BoxTree boxes = triangle_boxes(flat);
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const Vec3 place = places.row(i), normal = outward.row(i);
    const auto faces_it = [&](const SurfacePoint& hit) {
      const auto [a, b, c] = corners_of(flat, hit.triangle);
      const Vec3 area = (b - a).cross(c - a);
      return area.dot(normal) >= 0.3 * area.norm();  // a thin body's other side is never hit
    };
    std::optional<SurfacePoint> hit =
        closest_point(flat, boxes, place, std::numeric_limits<double>::infinity(), faces_it);
    if (!hit) hit = closest_point(flat, boxes, place);
    double r = 0, s = 0;
    for (int k = 0; k < 3; ++k) {
      r += hit->weight[k] * kNodeR[kQuarter[hit->triangle % 4][k]];
      s += hit->weight[k] * kNodeS[kQuarter[hit->triangle % 4][k]];
    }
    FacePlace found{{}, face_point(0, r, s).shape};
    for (int a = 0; a < kFaceNodes; ++a) found.node[a] = mesh.faces(hit->triangle / 4, a);
    places_.push_back(found);
  }
}

Eigen::VectorXf SurfacePlaces::displacement(const Points& u, double quantum_m) const {
  Eigen::VectorXf out(3 * static_cast<Eigen::Index>(places_.size()));
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Vec3 moved = Vec3::Zero();
    for (int a = 0; a < kFaceNodes; ++a)
      moved += places_[i].shape[a] * u.row(places_[i].node[a]).transpose();
    for (int k = 0; k < 3; ++k)
      out[3 * static_cast<Eigen::Index>(i) + k] =
          static_cast<float>(std::round(moved[k] / quantum_m) * quantum_m);
  }
  return out;
}

}  // namespace palpate::fem
