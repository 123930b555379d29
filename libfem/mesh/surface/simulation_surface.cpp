#include "libfem/mesh/surface/simulation_surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "libfem/mesh/surface/remesh.hpp"
#include "libfem/mesh/surface/surface_checks.hpp"
#include "libfem/mesh/topology.hpp"
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

// Distance of each fine vertex from the coarse surface.
Eigen::VectorXd distance_m(const Surface& fine, const Surface& coarse) {
  const BoxTree boxes = triangle_boxes(coarse);
  Eigen::VectorXd out(fine.vertices.rows());
  for (Eigen::Index v = 0; v < out.size(); ++v)
    out[v] = closest_point(coarse, boxes, fine.vertices.row(v))->distance_m;
  return out;
}

// A coarse surface, what keeps it from standing in for the fine one, if anything does, and where.
struct Attempt {
  SimulationSurface made;
  std::optional<std::string> fault;
  std::vector<Eigen::Index> too_coarse;  // fine vertices
};

// Surfaces with edges as wanted, of one target after the other.
class CoarseSurfaces {
 public:
  CoarseSurfaces(const Surface& fine, double target_edge_m, const SimulationSurfaceOptions& options)
      : fine_(fine),
        boxes_(triangle_boxes(fine)),
        volume_m3_(palpate::volume_m3(fine)),
        stray_m_(options.stray_tolerance * target_edge_m),
        options_(options) {}

  // Rounds of shorter edges where a surface crosses itself or is farther off than allowed. The
  // closest that is sound, or the first.
  Attempt at(double target_m) const {
    constexpr int kRounds = 6;
    constexpr double kShorter = 0.7;        // halves a chord's deviation
    constexpr double kShortestEdge = 0.15;  // of the target
    Eigen::VectorXd wanted = wanted_edge_m(fine_, boxes_, target_m);
    Attempt best = made(target_m, wanted), last = best;
    for (int round = 0; round < kRounds && !last.too_coarse.empty(); ++round) {
      for (const Eigen::Index v : last.too_coarse)
        wanted[v] = std::min(wanted[v], std::max(kShorter * wanted[v], kShortestEdge * target_m));
      limit_growth(wanted, fine_);
      last = made(target_m, wanted);
      if (!last.fault && (best.fault || last.made.excess < best.made.excess)) best = last;
    }
    return best;
  }

 private:
  Attempt made(double target_m, const Eigen::VectorXd& wanted) const {
    Attempt out;
    SimulationSurface& made = out.made;
    made.surface = remesh(fine_, boxes_, wanted);
    made.target_edge_m = target_m;
    made.deviation_m = deviation_m(fine_, boxes_, made.surface);
    out.fault = why_not_closed(made.surface);
    if (out.fault) return out;
    const double volume_change = palpate::volume_m3(made.surface) / volume_m3_ - 1;
    if (std::abs(volume_change) > options_.volume_tolerance)
      out.fault = "its volume is off by " + std::to_string(100 * volume_change) + " %";
    else if (made.deviation_m > stray_m_)
      out.fault = "it strays by " + std::to_string(1e3 * made.deviation_m) + " mm";
    const Surface crossing = crossing_part(made.surface);
    if (crossing.triangles.rows() > 0) {
      if (!out.fault) out.fault = "it crosses itself";
      const Eigen::VectorXd to_crossing_m = distance_m(fine_, crossing);
      for (Eigen::Index v = 0; v < wanted.size(); ++v)
        if (to_crossing_m[v] < wanted[v] / 2) out.too_coarse.push_back(v);
    }
    if (options_.allowed_m.size() == 0) return out;
    const Eigen::VectorXd excess =
        distance_m(fine_, made.surface).cwiseQuotient(options_.allowed_m);
    made.excess = excess.maxCoeff();
    for (Eigen::Index v = 0; v < wanted.size(); ++v)
      if (excess[v] > 1) out.too_coarse.push_back(v);
    sort_unique(out.too_coarse);
    return out;
  }

  const Surface& fine_;
  BoxTree boxes_;
  double volume_m3_, stray_m_;
  const SimulationSurfaceOptions& options_;
};

}  // namespace

SimulationSurface simulation_surface(const Surface& fine, double target_edge_m,
                                     const SimulationSurfaceOptions& options) {
  refuse_bad_input(fine, target_edge_m);
  constexpr int kAttempts = 5;
  constexpr double kFiner = 0.75;  // nearly halves the chords' deviation, which goes as the square
  const CoarseSurfaces coarse(fine, target_edge_m, options);
  std::string refused;
  double target = target_edge_m;
  for (int attempt = 1; attempt <= kAttempts; ++attempt, target *= kFiner) {
    Attempt at = coarse.at(target);
    if (!at.fault) {
      at.made.refused = refused;
      return at.made;
    }
    refused = "with a target of " + std::to_string(target * 1e3) + " mm " + *at.fault;
  }
  if (is_self_intersecting(fine))
    throw Error("surface",
                "it crosses itself, and no coarser surface of it is sound (" + refused + ")",
                "Mend the self-intersections first.");
  return {.surface = fine, .refused = refused};
}

}  // namespace palpate
