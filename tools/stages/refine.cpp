#include "tools/stages/refine.hpp"

#include "libfit/refine/refine.hpp"
#include "tools/console.hpp"
#include "tools/scene/scene.hpp"

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
  if (!body.scene.empty())
    model.probe_radius_m = recorded_radius_m(parse_scene(body.scene, "body.h5: scene").probe);
  return model;
}

}  // namespace palpate::tools
