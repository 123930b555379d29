#include "tools/stages/refine.hpp"

#include <charconv>

#include "libfit/core/error.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/refine/side_force.hpp"
#include "tools/console.hpp"

namespace palpate::tools {

Model refine_body(const FittedCurves& curves, const Body& body, const RefineOptions& options) {
  RefineReport report;
  Model model = refine(curves, body, options, &report);
  say("  {} test points spread over {} triangles{}; largest distance of a vertex {:.2f} mm",
      curves.position.rows() - static_cast<Eigen::Index>(report.left_out.size()),
      report.triangles.rows(), report.is_own_triangulation ? " made for them" : "",
      1e3 * report.largest_projection_m);
  if (const SlopeShare& slopes = report.slopes; slopes.points > 0)
    say("  {:.3g} of the slopes of side forces count: {} test points left out are predicted to "
        "{:.1f} % "
        "(mean), {:.1f} % without slopes",
        slopes.share, slopes.points, 100 * slopes.error, 100 * slopes.plain_error);
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
  return model;
}

std::optional<double> slope_share_choice(const std::string& text) {
  if (text == "auto") return std::nullopt;
  double share = -1;
  const char* const end = text.data() + text.size();
  const auto found = std::from_chars(text.data(), end, share);
  if (found.ec != std::errc{} || found.ptr != end || !(share >= 0 && share <= 0.5))
    throw Error("--slope-share", "\"" + text + "\" is no share of slopes",
                "Use auto or a number from 0 to 0.5.");
  return share;
}

}  // namespace palpate::tools
