#include "libfem/mesh/surface/surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfem/mesh/surface/half_edge.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

double one_sided_deviation_m(const Surface& from, const Surface& to, const BoxTree& boxes) {
  double largest = 0;
  const auto sample = [&](const Vec3& p) {
    if (const auto hit = closest_point(to, boxes, p)) largest = std::max(largest, hit->distance_m);
  };
  for (Eigen::Index f = 0; f < from.triangles.rows(); ++f) {
    const std::array<Vec3, 3> corner = corners_of(from, f);
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (from.triangles(f, k) > from.triangles(f, next)) continue;  // once per edge, when closed
      sample(corner[k]);
      sample((corner[k] + corner[next]) / 2);
    }
    sample((corner[0] + corner[1] + corner[2]) / 3);
  }
  return largest;
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
    Eigen::VectorXd wanted = wanted_edge_m(fine_, boxes_, target_m, options_.from_region_m);
    Attempt best = made(target_m, wanted), last = best;
    for (int round = 0; round < 6 && !last.too_coarse.empty(); ++round) {
      // Shorter by 0.7, a chord's deviation halves; edges keep 0.15 of the target.
      for (const Eigen::Index v : last.too_coarse)
        wanted[v] = std::min(wanted[v], std::max(0.7 * wanted[v], 0.15 * target_m));
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
    const Surface crossing = repair::crossing_part(made.surface);
    if (crossing.triangles.rows() > 0) {
      if (!out.fault) out.fault = "it crosses itself";
      const Eigen::VectorXd to_crossing_m = distances_m(fine_, crossing);
      for (Eigen::Index v = 0; v < wanted.size(); ++v)
        if (to_crossing_m[v] < wanted[v] / 2) out.too_coarse.push_back(v);
    }
    if (options_.allowed_m.size() == 0) return out;
    const Eigen::VectorXd excess =
        distances_m(fine_, made.surface).cwiseQuotient(options_.allowed_m);
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

Eigen::VectorXd distances_m(const Surface& of, const Surface& from) {
  const BoxTree boxes = triangle_boxes(from);
  Eigen::VectorXd out(of.vertices.rows());
  for (Eigen::Index v = 0; v < out.size(); ++v)
    out[v] = closest_point(from, boxes, of.vertices.row(v))->distance_m;
  return out;
}

double deviation_m(const Surface& a, const BoxTree& boxes_of_a, const Surface& b) {
  return std::max(one_sided_deviation_m(b, a, boxes_of_a),
                  one_sided_deviation_m(a, b, triangle_boxes(b)));
}

SimulationSurface simulation_surface(const Surface& fine, double target_edge_m,
                                     const SimulationSurfaceOptions& options) {
  if (const auto why = why_not_closed(fine))
    throw Error("surface", "it bounds no volume: " + *why,
                "Mend the surface, or prepare it with --surface-only.");
  const CoarseSurfaces coarse(fine, target_edge_m, options);
  std::string refused;
  double target = target_edge_m;
  // A target of 0.75 nearly halves the chords' deviation, which goes as the square.
  for (int attempt = 1; attempt <= 5; ++attempt, target *= 0.75) {
    Attempt at = coarse.at(target);
    if (!at.fault) {
      at.made.refused = refused;
      return at.made;
    }
    refused = "with a target of " + std::to_string(target * 1e3) + " mm " + *at.fault;
  }
  if (!repair::self_intersections(fine).empty())
    throw Error("surface",
                "it crosses itself, and no coarser surface of it is sound (" + refused + ")",
                "Mend the self-intersections first.");
  return {.surface = fine, .refused = refused};
}

}  // namespace palpate
