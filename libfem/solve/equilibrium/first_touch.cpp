#include <algorithm>
#include <cmath>

#include "libfem/contact/face_rule.hpp"
#include "libfem/solve/equilibrium/path_follower.hpp"

namespace palpate::fem {
namespace {

/// Whether the outward normal is against the axis at a corner or in the middle.
bool looks_against(const FaceNodes& nodes, const Vec3& axis) {
  constexpr double kPlaces[][2] = {{0, 0}, {1, 0}, {0, 1}, {1.0 / 3, 1.0 / 3}};
  return std::ranges::any_of(kPlaces, [&](const auto& at) {
    return area_normal_at(face_point(0, at[0], at[1]), nodes).dot(axis) < 0;
  });
}

double gap_at(const FaceNodes& nodes, const Probe& probe, const ProbePose& pose, double r,
              double s) {
  return probe.distance(pose.axis, place_at(face_point(0, r, s), nodes) - pose.tip).distance_m;
}

/// Least gap over one curved face: a grid, then ever smaller grids about the best point.
double min_gap_of_face(const FaceNodes& nodes, const Probe& probe, const ProbePose& pose) {
  constexpr int kGrid = 4, kRounds = 12;
  double r0 = 1.0 / 3, s0 = 1.0 / 3, half = 2.0 / 3;
  double least = gap_at(nodes, probe, pose, r0, s0);
  for (int round = 0; round < kRounds; ++round, half /= 2) {
    const double centre_r = r0, centre_s = s0;
    for (int i = -kGrid; i <= kGrid; ++i)
      for (int j = -kGrid; j <= kGrid; ++j) {
        const double r = std::clamp(centre_r + half * i / kGrid, 0.0, 1.0);
        const double s = std::clamp(centre_s + half * j / kGrid, 0.0, 1.0 - r);
        const double gap = gap_at(nodes, probe, pose, r, s);
        if (gap < least) {
          least = gap;
          r0 = r;
          s0 = s;
        }
      }
  }
  return least;
}

}  // namespace

std::optional<double> first_touch_m(const QuadraticMesh& mesh, const Probe& probe,
                                    const ProbePose& pose, double reach_m) {
  // Faces that may touch: not held, and looking against the axis somewhere.
  std::vector<FaceNodes> faces;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const FaceNodes nodes = nodes_of_face(mesh.nodes, mesh.faces.row(f));
    bool is_open = false;
    for (const std::int32_t n : mesh.faces.row(f)) is_open |= !mesh.is_held[n];
    if (is_open && looks_against(nodes, pose.axis)) faces.push_back(nodes);
  }
  double travel = 0;
  for (int advance = 0; advance < 200; ++advance) {
    const ProbePose here{pose.tip + travel * pose.axis, pose.axis};
    double least = 1e300;
    for (const FaceNodes& nodes : faces) {
      // Cheap lower bound first: distances are Lipschitz 1.
      double spread = 0;
      const Vec3 middle = place_at(face_point(0, 1.0 / 3, 1.0 / 3), nodes);
      for (const Vec3& node : nodes) spread = std::max(spread, (node - middle).norm());
      const double bound = gap_at(nodes, probe, here, 1.0 / 3, 1.0 / 3) - 1.5 * spread;
      if (bound < least) least = std::min(least, min_gap_of_face(nodes, probe, here));
    }
    if (std::abs(least) <= 1e-9 * probe.length_m) return travel;
    travel += least;  // no point of the probe moves farther than it travels
    if (std::abs(travel) > reach_m) return std::nullopt;
  }
  return travel;
}

}  // namespace palpate::fem
