#include "tools/stages/refine.hpp"

#include "libfit/refine/refine.hpp"
#include "tools/console.hpp"

namespace palpate::tools {

Model refine_body(const FittedCurves& curves, const Body& body) {
  RefineReport report;
  Model model = refine(curves, body, {}, &report);
  say("  {} test points spread over {} triangles{}; largest distance of a vertex {:.2f} mm",
      curves.position.rows() - static_cast<Eigen::Index>(report.left_out.size()),
      report.triangles.rows(), report.is_own_triangulation ? " made for them" : "",
      1e3 * report.largest_projection_m);
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

}  // namespace palpate::tools
