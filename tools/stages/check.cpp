#include "tools/stages/check.hpp"

#include <fmt/format.h>

#include <optional>

#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "tools/console.hpp"
#include "tools/stages/plausibility.hpp"
#include "tools/stages/simulate.hpp"

namespace palpate::tools {

void check_choices(const Scene& scene) {
  const std::string file = scene.path.string();
  if (!scene.material)
    throw Error(file, "the scene has no [material]",
                "Add [material] with law and its parameters, such as young and poisson.");
  fem::make_probe(scene.probe.spec, file + ": [probe]");
}

void check_experiments(const Scene& scene, const Body& body) {
  const fem::SimulationSetup setup = make_setup(scene, body);
  const std::string file = scene.path.string();
  const auto in_scene = [&](const Error& e) {
    return Error(file + ": " + e.where(), e.fact(), e.remedy());
  };
  try {
    fem::check_setup(setup);
  } catch (const Error& e) {
    throw in_scene(e);
  }
  say_plausibility(scene, body);
  const double thinnest_m = extent_m(body.surface.vertices).minCoeff();
  if (scene.experiments.each.depth_m >= thinnest_m)
    throw Error(file + ": [experiments] depth",
                fmt::format("the depth of {:.4g} mm is more than the body is thick ({:.4g} mm)",
                            1e3 * scene.experiments.each.depth_m, 1e3 * thinnest_m),
                "Press less deep, or check the unit of depth and length_unit.");
  // A depth beyond the thickness is an error of the scene when it is so at most points; a few
  // points on a thin rim bend out of the way, and their rows tell how far that went.
  std::optional<Error> first;
  Eigen::Index refused = 0;
  const Eigen::Index points = body.test_points.position.rows();
  for (Eigen::Index p = 0; p < points; ++p) {
    try {
      fem::check_experiments(setup, experiments_of(scene), body.test_points.position.row(p),
                             body.test_points.normal.row(p));
    } catch (const Error& e) {
      ++refused;
      if (!first) first = in_scene(e);
    }
  }
  if (2 * refused > points) throw *first;
  if (refused) say("  {} of {} test points are on parts thinner than the depth", refused, points);
}

}  // namespace palpate::tools
