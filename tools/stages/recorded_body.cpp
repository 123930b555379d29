#include "tools/stages/recorded_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/stated_error.hpp"
#include "tools/console.hpp"
#include "tools/stages/import.hpp"

namespace palpate::tools {
namespace {

// Points of samples, with the smallest deviation of the contacts found at each; 0: unknown.
Contacts contacts_of(const Samples& samples) {
  Contacts out{samples.point_position, samples.point_normal,
               Eigen::VectorXd::Zero(samples.points())};
  const MeasuredRecordings& recordings = samples.recordings;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const auto row = std::ranges::find(samples.experiment, recordings.experiment[r]);
    if (row == samples.experiment.end()) continue;
    const auto at = static_cast<std::size_t>(row - samples.experiment.begin());
    double& deviation_m = out.deviation_m[samples.point[at]];
    const double found_m = recordings.contact_deviation_m[r];
    if (found_m > 0 && (deviation_m == 0 || found_m < deviation_m)) deviation_m = found_m;
  }
  return out;
}

}  // namespace

ContactSurface surface_of_contacts(const Samples& samples) {
  const ContactSurface made = surface_from_contacts(contacts_of(samples));
  std::vector<double> off_m;
  for (const double m : made.left_out_m)
    if (std::isfinite(m)) off_m.push_back(std::abs(m));
  say("  {} through {} contacts, {:.3g} mm apart (median): {} triangles",
      made.is_height_field ? "height field" : "surface around the body", made.left_out_m.size(),
      1e3 * made.spacing_m, made.surface.triangles.rows());
  if (off_m.empty())
    say("  contacts are too few to leave any out: how well the surface fits is not known");
  else
    say("  contacts left out lie {:.3g} mm off the surface of the others (median), {:.3g} mm "
        "(p95), "
        "{:.3g} mm at most; quadrics reach {:g} spacings{}",
        1e3 * stated_quantile(off_m, 0.5), 1e3 * stated_quantile(off_m, 0.95),
        1e3 * stated_quantile(off_m, 1), made.reach,
        made.uses_normals ? ", normals count" : ", normals do not count");
  return made;
}

std::string obj_text(const Surface& surface) {
  std::string text = "# palpate surface, length_unit = \"mm\"\n";
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", 1e3 * surface.vertices(v, 0),
                        1e3 * surface.vertices(v, 1), 1e3 * surface.vertices(v, 2));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    text += fmt::format("f {} {} {}\n", surface.triangles(t, 0) + 1, surface.triangles(t, 1) + 1,
                        surface.triangles(t, 2) + 1);
  return text;
}

Body body_of_recordings(const Manifest& manifest, const Samples& samples) {
  Body body;
  auto given = surface_of(manifest);
  body.surface = given ? std::move(*given) : surface_of_contacts(samples).surface;
  const auto vertices = static_cast<std::size_t>(body.surface.vertices.rows());
  body.in_region.assign(vertices, 1);
  body.is_reachable.assign(vertices, 1);
  body.test_points.position = samples.point_position;
  body.test_points.normal = samples.point_normal;
  body.test_points.name = samples.point_name;
  body.probe = samples.probe;
  return body;
}

}  // namespace palpate::tools
