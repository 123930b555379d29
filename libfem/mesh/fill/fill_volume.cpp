#include "libfem/mesh/fill/fill_volume.hpp"

#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "libfem/mesh/fill/cavities.hpp"
#include "libfem/mesh/fill/child_process.hpp"
#include "libfem/mesh/fill/mend_slivers.hpp"
#include "libfem/mesh/fill/meshers.hpp"
#include "libfem/mesh/fill/smooth_interior.hpp"
#include "libfem/mesh/surface/surface_checks.hpp"
#include "libfem/mesh/tet_quality.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

struct Filled {
  TetMesh mesh;
  TetQuality quality;
};

void refuse_bad_input(const Surface& closed, const FillOptions& options) {
  if (const auto why = why_not_closed(closed))
    throw Error("surface", "it cannot be filled: " + *why,
                "Mend the surface, or prepare it with --surface-only.");
  if (!(options.target_edge_m >= 0) || !(options.interior_growth >= 1) || options.max_nodes < 4 ||
      !(options.safety_limit_s > 0))
    throw Error("fill options", "an edge, growth or limit is out of range",
                "Give an edge >= 0, a growth >= 1 and limits > 0.");
}

double volume_of_edge_m3(double edge_m) { return edge_m * edge_m * edge_m / (6 * std::sqrt(2.0)); }

/// A mesh or the reason for none; smoothed, mended and checked.
std::variant<Filled, std::string> finish(std::variant<TetMesh, std::string> result,
                                         double surface_volume_m3, double volume_tolerance) {
  if (const auto* reason = std::get_if<std::string>(&result)) return *reason;
  Filled filled{std::get<TetMesh>(std::move(result)), {}};
  if (filled.mesh.tets.rows() == 0) return "made no tetrahedron";
  smooth_interior(filled.mesh);
  mend_slivers(filled.mesh, kSliverDeg);
  filled.quality = quality_of(filled.mesh);
  if (!(filled.quality.worst_mean_ratio > 0)) return "made a flat tetrahedron";
  const double ratio = filled.quality.volume_m3 / surface_volume_m3;
  if (!(std::abs(ratio - 1) <= volume_tolerance))
    return "filled " + std::to_string(100 * ratio) + " % of the surface's volume";
  return filled;
}

/// Whether a mesh of one setting is to be taken for that of a sparser one: not for a tenth of a
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
/// runs, the first that is good, else the best, is kept. The boundary is never split: that gave 6
/// to 10 times the tets on the liver and no better angle.
std::variant<Filled, std::string> run_tetgen(const Surface& closed, double interior_edge_m,
                                             const FillOptions& options) {
  if (is_self_intersecting(closed)) return "is not run on a surface that crosses itself";
  constexpr double kVolumeTolerance = 0.01;
  constexpr double kGoodDeg = 15;
  // Sparse first: each next pair gives about a tenth more tets.
  constexpr std::pair<double, double> kRatioAndAngle[] = {{1.8, 0},  {1.4, 0},  {1.8, 12},
                                                          {1.4, 12}, {1.2, 12}, {1.4, 18}};
  const Points cavities = cavity_points(closed);
  const double volume = volume_m3(closed);
  std::optional<Filled> best;
  std::string reason;
  for (const auto& [ratio, angle] : kRatioAndAngle) {
    const TetGenSettings settings{ratio, angle, volume_of_edge_m3(interior_edge_m),
                                  options.max_nodes};
    auto run = finish(run_in_child([&] { return fill_with_tetgen(closed, cavities, settings); },
                                   tetgen_failure, options.safety_limit_s),
                      volume, kVolumeTolerance);
    if (const auto* why = std::get_if<std::string>(&run)) {
      reason = *why;
      continue;
    }
    auto& filled = std::get<Filled>(run);
    if (!best || is_better(filled, *best)) best = std::move(filled);
    if (best->quality.min_dihedral_deg >= kGoodDeg) break;
  }
  if (best) return std::move(*best);
  return reason;
}

std::variant<Filled, std::string> run_mesh_3(const Surface& closed, double edge_m,
                                             double interior_edge_m, const FillOptions& options) {
  constexpr double kVolumeTolerance = 0.1;  // its surface is its own, and crossings have no volume
  constexpr double kFacetDistance = 0.08;   // of the edge, as the simulation surface's
  return finish(
      run_in_child(
          [&] {
            return fill_with_mesh_3(closed, edge_m, interior_edge_m, kFacetDistance * edge_m,
                                    options.max_nodes);
          },
          [](int code) { return "threw " + std::to_string(code); }, options.safety_limit_s),
      volume_m3(closed), kVolumeTolerance);
}

/// One sliver in a hundred tets changes no force by more than the rows' error
/// (tests/validation/hard_cases_test).
bool has_few_slivers(const Filled& filled) {
  return 100 * Eigen::Index{filled.quality.slivers} <= filled.mesh.tets.rows();
}

void fill_report(FillReport& report, Mesher mesher, const Filled& filled, double volume) {
  report.mesher = mesher;
  report.nodes = static_cast<int>(filled.mesh.nodes.rows());
  report.tets = static_cast<int>(filled.mesh.tets.rows());
  report.min_dihedral_deg = filled.quality.min_dihedral_deg;
  report.worst_mean_ratio = filled.quality.worst_mean_ratio;
  report.slivers = filled.quality.slivers;
  report.volume_ratio = filled.quality.volume_m3 / volume;
}

}  // namespace

double mean_edge_m(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      sum += (surface.vertices.row(t[k]) - surface.vertices.row(t[(k + 1) % 3])).norm();
  return sum / static_cast<double>(3 * surface.triangles.rows());
}

double expected_tets(double volume_m3, double area_m2, double edge_m, double interior_growth) {
  constexpr double kMeanEdge = 0.6;                    // over the edge asked for
  constexpr double kPerTriangle = 1.4, kInside = 1.5;  // tets, and over regular ones
  const double mean_m = kMeanEdge * edge_m;
  const double triangles = area_m2 / (std::sqrt(3.0) / 4 * mean_m * mean_m);
  return kPerTriangle * triangles +
         kInside * volume_m3 / volume_of_edge_m3(interior_growth * edge_m);
}

TetMesh fill_volume(const Surface& given, const FillOptions& options, FillReport* report) {
  refuse_bad_input(given, options);
  const double scale = std::exp2(-std::round(std::log2(extent_m(given.vertices).maxCoeff())));
  const Surface closed{scale * given.vertices, given.triangles};
  const double edge_m =
      options.target_edge_m > 0 ? scale * options.target_edge_m : mean_edge_m(closed);
  const double interior_edge_m = edge_m * options.interior_growth;
  FillReport own;
  FillReport& result = report ? *report : own;
  result = {};
  std::optional<Filled> best;
  for (const Mesher mesher : {Mesher::tetgen, Mesher::mesh_3}) {
    if (options.mesher != Mesher::automatic && options.mesher != mesher) continue;
    if (best && has_few_slivers(*best)) break;  // the second only where the first falls short
    const std::string name = mesher == Mesher::tetgen ? "TetGen " : "Mesh_3 ";
    auto run = mesher == Mesher::tetgen ? run_tetgen(closed, interior_edge_m, options)
                                        : run_mesh_3(closed, edge_m, interior_edge_m, options);
    if (const auto* reason = std::get_if<std::string>(&run)) {
      result.notes.push_back(name + *reason);
      continue;
    }
    auto& filled = std::get<Filled>(run);
    if (filled.quality.slivers > 0)
      result.notes.push_back(name + "left " + counted(filled.quality.slivers, "sliver", "slivers") +
                             " of " + std::to_string(filled.mesh.tets.rows()) + " tets");
    if (best && best->quality.slivers <= filled.quality.slivers) continue;
    fill_report(result, mesher, filled, volume_m3(closed));
    best = std::move(filled);
  }
  if (best) {
    best->mesh.nodes /= scale;
    return std::move(best->mesh);
  }
  std::string reasons;
  for (const auto& note : result.notes) reasons += (reasons.empty() ? "" : "; ") + note;
  throw Error("filling the surface", reasons,
              "Mend the surface (self-intersections, slits), or try another edge length.");
}

}  // namespace palpate
