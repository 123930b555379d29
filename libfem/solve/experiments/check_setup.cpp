#include <algorithm>
#include <cmath>
#include <limits>

#include "libfem/mesh/tets.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate::fem {
namespace {

void need(bool is_so, const char* where, const std::string& what, const std::string& remedy) {
  if (!is_so) throw Error(where, what, remedy);
}

/// Thickness [m] of the body from a surface point along the inward normal; +inf where the ray meets
/// no second sheet.
double thickness_m(const Surface& surface, const Vec3& position, const Vec3& normal,
                   double skip_m) {
  double thickness = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    const double hit = ray_hit_m(position, normal, a, b, c);
    if (hit > skip_m) thickness = std::min(thickness, hit);
  }
  return thickness;
}

// One sliver in a hundred changes no force by more than the rows' error; a mesh of which every
// inner node makes slivers was 8 to 15 % too stiff in rows that claimed 2
// (tests/validation/hard_cases_test).
constexpr double kFlatDeg = 2, kMaxFlat = 0.05;

/// Share of the tets of which two faces meet at less than kFlatDeg.
double flat_share(const TetMesh& mesh) {
  Eigen::Index flat = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    flat += min_dihedral_deg(corners_of(mesh, t)) < kFlatDeg;
  return static_cast<double>(flat) / static_cast<double>(mesh.tets.rows());
}

}  // namespace

void check_setup(const SimulationSetup& setup) {
  need(setup.volume.tets.rows() > 0, "[body]", "the body has no volume mesh",
       "Prepare it without --surface-only.");
  need(setup.volume.nodes.allFinite(), "[body]", "a node of the volume is not finite",
       "Prepare the body again.");
  need(setup.is_held.size() == static_cast<std::size_t>(setup.volume.nodes.rows()), "[body] fixed",
       "held flags do not match the nodes of the volume", "Prepare the body again.");
  need(
      flat_share(setup.volume) <= kMaxFlat, "[body]",
      "more than one tetrahedron in twenty is flatter than 2 degrees, which makes a body too stiff",
      "Give the surface alone, so that it is filled anew, or a better mesh.");
  const auto held = std::count(setup.is_held.begin(), setup.is_held.end(), char(1));
  need(held >= 3 || setup.bed_at, "[body] fixed",
       held == 0 ? "no node is held, so a press would push the body away"
                 : "fewer than three nodes are held, so a press would turn the body about them",
       "Give `fixed` a region that holds part of the body, such as the face it lies on.");
  need(!setup.materials.empty(), "[material]", "no material is given",
       "Name a law and its parameters.");
  for (std::size_t m = 0; m < setup.materials.size(); ++m)
    make_material(setup.materials[m], m == 0 ? "[material]" : "[[inclusion]] " + std::to_string(m));
  const Probe probe = make_probe(setup.probe, "[probe]");
  const double largest_m = extent_m(setup.volume.nodes).maxCoeff();
  need(2 * probe.half_width_m <= largest_m, "[probe]",
       "the probe (" + millimetres(2 * probe.half_width_m) + " wide) is larger than the body (" +
           millimetres(largest_m) + ")",
       "Check length_unit and the size of the probe.");
}

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
       "depth " + millimetres(experiments.depth_m) + " is more than the body is thick (" +
           millimetres(thick) + ") at a test point",
       "Press less deep, or restrict the region of test points.");
}

}  // namespace palpate::fem
