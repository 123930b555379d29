#include "libfem/mesh/fill/fill_volume.hpp"

#define TETLIBRARY  // the interface that throws instead of leaving the process
#include <tetgen.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "libfem/mesh/fill/fill_steps.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr double kInteriorGrowth = 1.6;  // interior edge over that near the surface

struct Filled {
  TetMesh mesh;
  TetQuality quality;
};

double volume_of_edge_m3(double edge_m) { return edge_m * edge_m * edge_m / (6 * std::sqrt(2.0)); }

/// Midpoint from the piece's largest triangle to what lies across the cavity.
Vec3 point_across(const Surface& piece, const Surface& closed, const BoxTree& boxes) {
  double largest = -1;
  Vec3 start = Vec3::Zero(), direction = Vec3::Zero();
  for (Eigen::Index f = 0; f < piece.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(piece, f);
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.norm() <= largest) continue;
    largest = normal.norm();
    start = (a + b + c) / 3;
    direction = normal.normalized();  // out of the solid, into the cavity
  }
  const double skip = 1e-6 * extent_m(piece.vertices).norm();
  const auto across = ray_distance_m(closed, boxes, start, direction, skip);
  return start + 0.5 * across.value_or(2 * skip) * direction;
}

/// A point strictly inside each cavity: one per part that points inward by itself.
Points cavity_points(const Surface& closed) {
  const BoxTree boxes = triangle_boxes(closed);
  Points points(0, 3);
  for (const Surface& part : parts_of(closed)) {
    if (volume_m3(part) > 0) continue;
    points.conservativeResize(points.rows() + 1, 3);
    points.bottomRows<1>() = point_across(part, closed, boxes).transpose();
  }
  return points;
}

/// A mesh or the reason for none; smoothed, mended and checked.
std::variant<Filled, std::string> finish(std::variant<TetMesh, std::string> result,
                                         double surface_volume_m3) {
  if (const auto* reason = std::get_if<std::string>(&result)) return *reason;
  Filled filled{std::get<TetMesh>(std::move(result)), {}};
  if (filled.mesh.tets.rows() == 0) return "made no tetrahedron";
  smooth_interior(filled.mesh);
  mend_slivers(filled.mesh, kSliverDeg);
  filled.quality = quality_of(filled.mesh);
  if (!(filled.quality.min_volume_m3 > 0)) return "made a flat tetrahedron";
  const double ratio = filled.quality.volume_m3 / surface_volume_m3;
  if (!(std::abs(ratio - 1) <= 0.01))
    return "filled " + std::to_string(100 * ratio) + " % of the surface's volume";
  return filled;
}

/// Compares a mesh of one setting with that of a sparser one: it is not better for a tenth of a
/// degree, and for a better angle alone not at half as many tets again.
bool is_better(const Filled& denser, const Filled& best) {
  constexpr double kMinGainDeg = 0.1, kMaxMoreTets = 1.5;
  if (denser.quality.slivers != best.quality.slivers)
    return denser.quality.slivers < best.quality.slivers;
  return denser.quality.min_dihedral_deg > best.quality.min_dihedral_deg + kMinGainDeg &&
         static_cast<double>(denser.mesh.tets.rows()) <=
             kMaxMoreTets * static_cast<double>(best.mesh.tets.rows());
}

/// TetGen's luck varies with its settings, and a run takes a few hundredths of a second: of several
/// runs, the first that is good, else the best, is kept. The boundary is never split: with that it
/// has 6 to 10 times the tets on the liver and no better angle.
TetMesh run_tetgen(const Surface& closed, double interior_edge_m) {
  // Sparse first: each next pair makes about a tenth more tets.
  constexpr std::pair<double, double> kRatioAndAngle[] = {{1.8, 0},  {1.4, 0},  {1.8, 12},
                                                          {1.4, 12}, {1.2, 12}, {1.4, 18}};
  const Points cavities = cavity_points(closed);
  const double volume = volume_m3(closed);
  std::optional<Filled> best;
  std::string reason;
  for (const auto& [ratio, angle] : kRatioAndAngle) {
    // Grading takes no more points inside.
    const TetGenSettings settings{ratio, angle, volume_of_edge_m3(interior_edge_m), 200'000};
    // An hour of CPU time guards against endless loops.
    auto run = finish(run_in_child([&] { return fill_with_tetgen(closed, cavities, settings); },
                                   tetgen_failure, 3600),
                      volume);
    if (const auto* why = std::get_if<std::string>(&run)) {
      reason = *why;
      continue;
    }
    auto& filled = std::get<Filled>(run);
    if (!best || is_better(filled, *best)) best = std::move(filled);
    if (best->quality.min_dihedral_deg >= 15) break;  // good enough
  }
  if (best) return std::move(best->mesh);
  throw Error("filling the surface", "TetGen " + reason,
              "Mend the surface (self-intersections, slits), or try another edge length.");
}

constexpr double kMinGainDeg = 0.02;  // less is not worth an evaluation

/// Smallest dihedral angle of the tets around a node [deg], negative when one is inside out; stops
/// at the first tet no better than `enough_deg`.
double worst_around(const TetMesh& mesh, const std::vector<std::int32_t>& around,
                    double enough_deg = -1) {
  double worst = 180;
  for (const std::int32_t t : around) {
    if (worst <= enough_deg) break;
    const TetCorners corner = corners_of(mesh, t);
    if (!(tet_volume_m3(corner) > 0)) return -1;
    worst = std::min(worst, min_dihedral_deg(corner));
  }
  return worst;
}

double mean_edge_m(const TetMesh& mesh, std::int32_t node, const std::vector<std::int32_t>& around,
                   Vec3& centre) {
  double sum = 0;
  centre.setZero();
  for (const std::int32_t t : around)
    for (int k = 0; k < 4; ++k) {
      const auto other = mesh.tets(t, k);
      if (other == node) continue;
      sum += (mesh.nodes.row(other) - mesh.nodes.row(node)).norm();
      centre += mesh.nodes.row(other).transpose();
    }
  const double count = 3.0 * static_cast<double>(around.size());
  centre /= count;
  return sum / count;
}

/// Pattern search over the axes, their diagonals and towards the middle of the neighbours.
void smooth_node(TetMesh& mesh, std::int32_t node, const std::vector<std::int32_t>& around) {
  double best = worst_around(mesh, around);
  if (best > 22) return;  // a node whose tets all pass is left alone
  Vec3 centre;
  const double edge = mean_edge_m(mesh, node, around, centre);
  Vec3 at = mesh.nodes.row(node);
  const auto accepts = [&](const Vec3& candidate) {
    const Vec3 before = mesh.nodes.row(node);
    mesh.nodes.row(node) = candidate;
    const double worst = worst_around(mesh, around, best + kMinGainDeg);
    if (worst > best + kMinGainDeg) {
      best = worst;
      return true;
    }
    mesh.nodes.row(node) = before;
    return false;
  };
  if (accepts(centre)) at = centre;
  search_place(at, edge, accepts);
}

/// TetGen's input. It owns plain arrays that tetgenio's destructor deletes, so all are new[]-ed.
void set_input(tetgenio& in, const Surface& closed, const Points& cavities) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(closed.vertices.rows());
  in.pointlist = new REAL[closed.vertices.size()];
  std::copy_n(closed.vertices.data(), closed.vertices.size(), in.pointlist);

  in.numberoffacets = static_cast<int>(closed.triangles.rows());
  in.facetlist = new tetgenio::facet[in.numberoffacets];
  for (Eigen::Index f = 0; f < closed.triangles.rows(); ++f) {
    tetgenio::facet& facet = in.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (int k = 0; k < 3; ++k) polygon.vertexlist[k] = closed.triangles(f, k);
  }
  if (cavities.rows() == 0) return;
  in.numberofholes = static_cast<int>(cavities.rows());
  in.holelist = new REAL[cavities.size()];
  std::copy_n(cavities.data(), cavities.size(), in.holelist);
}

/// Nodes and tets, each turned positive; nodes that no tet uses are left out.
TetMesh to_tet_mesh(const tetgenio& out) {
  TetMesh mesh;
  mesh.tets = Eigen::Map<const Tets>(out.tetrahedronlist, out.numberoftetrahedra, 4);
  const auto used = renumber({mesh.tets.data(), std::size_t(mesh.tets.size())}, out.numberofpoints,
                             Numbering::by_use);
  mesh.nodes = Eigen::Map<const Points>(out.pointlist, out.numberofpoints, 3)(used, Eigen::all);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    if (tet_volume_m3(corners_of(mesh, t)) < 0) std::swap(mesh.tets(t, 0), mesh.tets(t, 1));
  return mesh;
}

}  // namespace

double expected_tets(double volume_m3, double area_m2, double edge_m) {
  constexpr double kPerTriangle = 1.4, kInside = 1.5;  // tets, and over regular ones
  const double mean_m = 0.6 * edge_m;  // the mean edge comes out at 0.6 of that asked for
  const double triangles = area_m2 / (std::sqrt(3.0) / 4 * mean_m * mean_m);
  return kPerTriangle * triangles +
         kInside * volume_m3 / volume_of_edge_m3(kInteriorGrowth * edge_m);
}

TetMesh fill_volume(const Surface& closed, double edge_m) {
  const double scale = std::exp2(-std::round(std::log2(extent_m(closed.vertices).maxCoeff())));
  TetMesh mesh =
      run_tetgen({scale * closed.vertices, closed.triangles}, scale * edge_m * kInteriorGrowth);
  mesh.nodes /= scale;
  return mesh;
}

void search_place(Vec3& at, double edge_m, const std::function<bool(const Vec3&)>& accepts) {
  double step = 0.2 * edge_m;
  // Twelve rounds end the search of a node.
  for (int round = 0; round < 12 && step > 0.01 * edge_m; ++round) {
    bool has_moved = false;
    for (int direction = 0; direction < 27; ++direction) {
      const Vec3 offset(direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1);
      if (direction == 13) continue;
      const Vec3 candidate = at + step * offset.normalized();
      if (!accepts(candidate)) continue;
      at = candidate;
      has_moved = true;
    }
    if (!has_moved) step /= 2;
  }
}

void smooth_interior(TetMesh& mesh) {
  const auto around = cells_around(mesh.tets, mesh.nodes.rows());
  std::vector<char> is_boundary(mesh.nodes.rows(), 0);
  const Triangles boundary = fem::boundary_triangles(mesh.tets);
  for (const std::int32_t v : boundary.reshaped()) is_boundary[v] = 1;
  for (int sweep = 0; sweep < 4; ++sweep) {  // a fifth changed nothing on the liver
    std::vector<std::pair<double, std::int32_t>> order;
    for (std::size_t v = 0; v < around.size(); ++v)
      if (!is_boundary[v] && !around[v].empty())
        order.emplace_back(worst_around(mesh, around[v]), static_cast<std::int32_t>(v));
    std::sort(order.begin(), order.end());
    for (const auto& [angle, node] : order) smooth_node(mesh, node, around[node]);
  }
}

TetMesh fill_with_tetgen(const Surface& closed, const Points& cavities,
                         const TetGenSettings& settings) {
  tetgenio in, out;
  set_input(in, closed, cavities);
  // p: fill a surface; Q: quiet; Y: leave the boundary alone; q: quality; a: volume; O9/7: optimise
  // with all means; S: how many points it may add.
  std::array<char, 128> switches{};
  std::snprintf(switches.data(), switches.size(), "pQYq%.3f/%.1fa%.15fO9/7S%d",
                settings.radius_edge_ratio, settings.min_dihedral_deg, settings.max_volume_m3,
                settings.max_added_points);
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (const int code) {
    if (code == 1) throw std::bad_alloc();  // TetGen is out of memory
    throw;
  }
  if (out.numberofpoints - in.numberofpoints >= settings.max_added_points)
    throw std::runtime_error("wanted more than " + std::to_string(settings.max_added_points) +
                             " points inside");
  return to_tet_mesh(out);
}

std::string tetgen_failure(int code) {
  switch (code) {
    case 2:
      return "met an error of its own";
    case 3:
      return "found that the surface crosses itself";
    case 4:
      return "found a feature too small for its tolerance";
    case 5:
      return "found two facets too close to each other";
    case 10:
      return "refused the input";
    default:
      return "failed with code " + std::to_string(code);
  }
}

}  // namespace palpate
