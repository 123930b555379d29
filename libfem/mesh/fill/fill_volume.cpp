#include "libfem/mesh/fill/fill_volume.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "libfem/mesh/fill/fill_steps.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/tets.hpp"
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

}  // namespace palpate
