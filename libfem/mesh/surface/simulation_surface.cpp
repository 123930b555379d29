#include "libfem/mesh/surface/simulation_surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "libfem/mesh/surface/remesh.hpp"
#include "libfem/mesh/surface/surface_checks.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

void refuse_bad_input(const Surface& fine, double target_edge_m) {
  if (!(target_edge_m > 0) || !std::isfinite(target_edge_m))
    throw Error("simulation surface", "the target edge is not a positive length",
                "Give an edge such as a tenth of the body's size.");
  if (const auto why = why_not_closed(fine))
    throw Error("surface", "it bounds no volume: " + *why,
                "Mend the surface, or prepare it with --surface-only.");
}

/// What keeps `coarse` from standing in for the fine surface, or nothing.
std::optional<std::string> find_fault(const SimulationSurface& coarse, double stray_m,
                                      double volume_tolerance) {
  if (const auto why = why_not_closed(coarse.surface)) return why;
  if (std::abs(coarse.volume_ratio - 1) > volume_tolerance)
    return "its volume is off by " + std::to_string(100 * (coarse.volume_ratio - 1)) + " %";
  if (coarse.deviation_m > stray_m)
    return "it strays by " + std::to_string(1e3 * coarse.deviation_m) + " mm";
  if (is_self_intersecting(coarse.surface)) return "it crosses itself";
  return std::nullopt;
}

// Of each fine vertex.
Eigen::VectorXd distance_m(const Surface& fine, const Surface& coarse) {
  const BoxTree boxes = triangle_boxes(coarse);
  Eigen::VectorXd out(fine.vertices.rows());
  for (Eigen::Index v = 0; v < out.size(); ++v)
    out[v] = closest_point(coarse, boxes, fine.vertices.row(v))->distance_m;
  return out;
}

// A surface closer to the fine one where it is farther than allowed. `wanted`: what `result` was
// made with.
void draw_closer(const Surface& fine, const BoxTree& boxes, Eigen::VectorXd wanted,
                 const SimulationSurfaceOptions& options, double stray_m,
                 SimulationSurface& result) {
  constexpr int kRounds = 6;
  constexpr double kShorter = 0.7;    // halves a chord's deviation
  constexpr double kShortest = 0.15;  // of the target
  const double least_m = kShortest * result.target_edge_m;
  Eigen::VectorXd off_m = distance_m(fine, result.surface);
  result.excess = (off_m.array() / options.allowed_m.array()).maxCoeff();
  for (int round = 0; round < kRounds && result.excess > 1; ++round) {
    for (Eigen::Index v = 0; v < wanted.size(); ++v)
      if (off_m[v] > options.allowed_m[v]) wanted[v] = std::max(kShorter * wanted[v], least_m);
    limit_growth(wanted, fine, SizingOptions{}.growth);
    SimulationSurface closer = result;
    closer.surface = remesh(fine, boxes, wanted, options.feature_angle_deg);
    closer.volume_ratio = volume_m3(closer.surface) / volume_m3(fine);
    closer.deviation_m = deviation_m(fine, boxes, closer.surface);
    off_m = distance_m(fine, closer.surface);
    closer.excess = (off_m.array() / options.allowed_m.array()).maxCoeff();
    if (closer.excess < result.excess && !find_fault(closer, stray_m, options.volume_tolerance))
      result = std::move(closer);
  }
}

}  // namespace

SimulationSurface simulation_surface(const Surface& fine, double target_edge_m,
                                     const SimulationSurfaceOptions& options) {
  refuse_bad_input(fine, target_edge_m);
  constexpr double kFiner = 0.75;  // nearly halves the chords' deviation, which goes as the square
  const BoxTree boxes = triangle_boxes(fine);
  const double fine_volume = volume_m3(fine);
  SimulationSurface result;
  double target = target_edge_m;
  for (int attempt = 1; attempt <= options.attempts; ++attempt, target *= kFiner) {
    const Eigen::VectorXd wanted = wanted_edge_m(fine, boxes,
                                                 {.target_edge_m = target,
                                                  .deviation_ratio = options.deviation_ratio,
                                                  .min_edge_ratio = options.min_edge_ratio,
                                                  .feature_angle_deg = options.feature_angle_deg});
    result.surface = remesh(fine, boxes, wanted, options.feature_angle_deg);
    result.attempts = attempt;
    result.target_edge_m = target;
    result.volume_ratio = volume_m3(result.surface) / fine_volume;
    result.deviation_m = deviation_m(fine, boxes, result.surface);
    const double stray_m = options.stray_tolerance * target_edge_m;
    const auto fault = find_fault(result, stray_m, options.volume_tolerance);
    if (!fault) {
      if (options.allowed_m.size() > 0) draw_closer(fine, boxes, wanted, options, stray_m, result);
      return result;
    }
    result.refused = "with a target of " + std::to_string(target * 1e3) + " mm " + *fault;
  }
  if (is_self_intersecting(fine))
    throw Error("surface",
                "it crosses itself, and no coarser surface of it is sound (" + result.refused + ")",
                "Mend the self-intersections first.");
  result.surface = fine;
  result.target_edge_m = 0;
  result.deviation_m = 0;
  result.volume_ratio = 1;
  return result;
}

}  // namespace palpate
