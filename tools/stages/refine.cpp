#include "tools/stages/refine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "libfem/probes/round_end.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/refine/side_force.hpp"
#include "tools/console.hpp"
#include "tools/stages/samples/coupling.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/shape.hpp"

namespace palpate::tools {

Samples read_known(const std::filesystem::path& samples) {
  return std::filesystem::exists(surface_path(samples)) ? read_with_surface(samples)
                                                        : read_samples(samples);
}

Model refine_body(const FittedCurves& curves, const Body& body, const RefineOptions& options,
                  const Samples& samples, const Scene* scene) {
  RefineReport report;
  RefineOptions with_tool = options;
  with_tool.tool = fem::round_end(curves.probe);
  Model model = refine(curves, body, with_tool, &report);
  if (static_cast<Eigen::Index>(report.left_out.size()) == curves.position.rows())
    throw Error("curves",
                fmt::format("none of the {} test points lies on this body with curves of its own",
                            curves.position.rows()),
                "Name the body.h5 that the samples were taken on; `fit` lists points without "
                "curves.");
  say("  {} test points spread over {} triangles{}; largest distance of a vertex {:.2f} mm",
      curves.position.rows() - static_cast<Eigen::Index>(report.left_out.size()),
      report.triangles.rows(),
      report.is_own_triangulation ? " made for them, since they are not the body's own" : "",
      1e3 * report.largest_projection_m);
  if (const InterpolationChoice& chosen = report.interpolation; chosen.points > 0)
    say("  {} test points left out are predicted to {:.1f} % (mean) by area alone, {:.1f} % with "
        "the slopes of side forces, {:.1f} % over the force of the gap under the tool{}: {}",
        chosen.points, 100 * chosen.plain_error, 100 * chosen.slope_error, 100 * chosen.gap_error,
        chosen.kriged_error > 0 ? fmt::format(", {:.1f} % kriged", 100 * chosen.kriged_error) : "",
        chosen.is_kriged         ? "forces are kriged"
        : chosen.follows_gap     ? "forces follow the gap"
        : chosen.slope_share > 0 ? fmt::format("{:.3g} of the slopes count", chosen.slope_share)
                                 : "area alone");
  if (report.interpolation.kriges_normals)
    say("  normals are kriged from the points' own ({:.1f} degrees off at points left out, the "
        "surface's "
        "{:.1f})",
        report.interpolation.kriged_normal_rad * 180 / std::numbers::pi,
        report.interpolation.surface_normal_rad * 180 / std::numbers::pi);
  if (curves.curves.family == CurveFamily::rings) {
    const SideMismatch off = side_mismatch(model);
    say("  side force off the slope of the normal energy by {:.2g} % of the normal force (median), "
        "{:.2g} % (p95), {:.2g} % (max)",
        100 * off.median, 100 * off.p95, 100 * off.max);
  }
  for (const auto point : report.left_out) {
    const auto p = static_cast<std::size_t>(point);
    say("  left out: {}: {}", curves.name[p],
        curves.message[p].empty() ? "too far from the surface" : curves.message[p]);
  }
  if (!report.uncovered.empty())
    say("  {} reachable vertices are answered for by no test point", report.uncovered.size());
  model.probe = curves.probe;
  if (samples.surface.rows() > 0)
    add_shape(model, of_kinds(samples, {ExperimentKind::press, ExperimentKind::drag}));
  if (scene != nullptr) add_coupling(model, *scene, samples);
  return model;
}

Attributes model_attributes(const FittedCurves& curves, const std::string& made_from) {
  Attributes out{{kInputsAttribute, made_from}};
  const auto guessed = std::ranges::count(curves.status, FitStatus::underdetermined);
  const auto failed = std::ranges::count(curves.status, FitStatus::failed);
  if (guessed + failed > 0)
    out[kGuessedAttribute] = fmt::format("{} of {}: {} underdetermined, {} failed",
                                         guessed + failed, curves.status.size(), guessed, failed);
  return out;
}

}  // namespace palpate::tools
