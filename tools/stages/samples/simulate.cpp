#include "tools/stages/samples/simulate.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "libfem/materials/relaxation.hpp"
#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/solve/experiments/contact_relaxation.hpp"
#include "libfem/solve/factor/blas.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/misread_unit.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;  // experiments named before "and N more"

void warn_of_foreign_blas() {
  const std::string file = fem::foreign_blas();
  if (!file.empty())
    warn(
        "{} computes in the place of OpenBLAS: reference BLAS and ATLAS take several times as "
        "long, and forces differ in their last digits",
        file);
}

}  // namespace

fem::SimulationSetup make_setup(const Scene& scene, const Body& body) {
  static std::once_flag said;
  std::call_once(said, warn_of_foreign_blas);
  fem::SimulationSetup setup;
  setup.volume = body.volume;
  setup.is_held = body.is_held;
  setup.held_at = [fixed = scene.body.fixed](const Vec3& place, bool is_on_boundary) {
    return any_contains(fixed, place, is_on_boundary);
  };
  setup.surface = body.surface;
  setup.materials.push_back(*scene.material);
  std::vector<Region> regions;
  for (const InclusionSection& inclusion : scene.inclusions) {
    setup.materials.push_back(inclusion.material);
    regions.push_back(inclusion.region);
  }
  // The last inclusion named wins where several overlap.
  if (!regions.empty())
    setup.region_at = [regions](const Vec3& place) {
      for (std::size_t i = regions.size(); i-- > 0;)
        if (contains(regions[i], place)) return static_cast<int>(i) + 1;
      return 0;
    };
  // Of a layer that is thin against its breadth: confined along the normal, in shear across (M13f).
  std::vector<std::pair<Region, fem::BedStiffness>> beds;
  for (const BedSection& bed : scene.beds) {
    const fem::Material layer = fem::make_material(bed.material, "material of [[bed]]");
    const fem::SmallStrain moduli = layer.law->small_strain(layer.constants);
    beds.push_back({bed.region,
                    {(moduli.lambda_Pa + 2 * moduli.mu_Pa) / bed.thickness_m,
                     bed.slides ? 0 : moduli.mu_Pa / bed.thickness_m}});
  }
  if (!scene.body.symmetric.empty()) {
    const fem::Material own = fem::make_material(*scene.material, "[material]");
    const double length_m = fem::make_probe(scene.probe.spec, "[probe]").length_m;
    for (const Region& region : scene.body.symmetric)
      beds.push_back({region, fem::plane_of_symmetry(own, length_m)});
  }
  if (!beds.empty())
    setup.bed_at = [beds](const Vec3& place) {
      for (const auto& [region, stiffness] : beds)
        if (contains(region, place)) return stiffness;
      return fem::BedStiffness{};
    };
  if (scene.gravity) {
    setup.weight = {scene.gravity->acceleration_m_s2, {scene.gravity->density_kg_m3}};
    for (const InclusionSection& inclusion : scene.inclusions)
      setup.weight.density_kg_m3.push_back(
          inclusion.density_kg_m3.value_or(scene.gravity->density_kg_m3));
    setup.regions_at_rest = scene.gravity->shape == kAtRest;
  }
  setup.probe = scene.probe.spec;
  setup.options.force_tolerance = scene.experiments.force_tolerance;
  setup.options.equilibrium.element =
      fem::find_element(scene.body.element, "element of [body]").kind;
  return setup;
}

bool relaxes(const Scene& scene) {
  const auto has_branches = [](const fem::MaterialParameters& material) {
    return material.relaxation.branches() > 0;
  };
  return (scene.material && has_branches(*scene.material)) ||
         std::ranges::any_of(scene.inclusions, has_branches, &InclusionSection::material);
}

bool keeps_surface(const Scene& scene, const Body& body) {
  return scene.experiments.surface && body.surface.vertices.rows() <= kMaxSurfaceVertices;
}

fem::Experiments experiments_of(const Scene& scene) {
  fem::Experiments experiments = scene.experiments.each;
  if (experiments.drag_directions == 0) experiments.drag_depths_m.clear();
  return experiments;
}

void add_origin(Samples& samples, const fem::Simulator& simulator) {
  const fem::SimulationSetup& setup = simulator.setup();
  samples.probe = setup.probe;
  const fem::Material material = fem::make_material(setup.materials.front(), "[material]");
  samples.poisson = material.law->small_strain(material.constants).poisson();
}

Relaxation contact_relaxation(const Scene& scene, const Body& body, const Samples& samples) {
  constexpr Eigen::Index kPoints = 3;
  if (!scene.material || scene.material->relaxation.branches() == 0) return {};
  TestPoints first;
  const Eigen::Index points = std::min(kPoints, samples.points());
  first.position = samples.point_position.topRows(points);
  first.normal = samples.point_normal.topRows(points);
  const double at_first =
      fem::force_at_first(fem::Simulator(make_setup(scene, body)), first, experiments_of(scene));
  const Relaxation relaxation =
      fem::relaxation_of_contact(fem::make_material(*scene.material, "[material]"), at_first);
  say("  relaxation: forces are {:.3f} times as large at first as in slow motion, where the "
      "material is {:.3f} times as stiff in shape",
      fem::instantaneous_stiffness(relaxation),
      fem::instantaneous_stiffness(scene.material->relaxation));
  return relaxation;
}

fem::Simulator make_simulator(const Scene& scene, const Body& body) {
  return make_simulator(scene, body, scene.experiments.force_tolerance);
}

fem::Simulator make_simulator(const Scene& scene, const Body& body, double force_tolerance) {
  fem::SimulationSetup setup = make_setup(scene, body);
  setup.options.force_tolerance = force_tolerance;
  setup.keeps_surface = keeps_surface(scene, body);
  return fem::Simulator(std::move(setup));
}

namespace {

// "rejected: overlaps"
std::string reason_of(const Samples& samples, std::size_t row) {
  std::string reason(kRowStatusNames[static_cast<std::size_t>(samples.status[row])]);
  if (samples.status[row] == RowStatus::wedged) {
    const auto at = static_cast<Eigen::Index>(row);
    const Vec3 force = samples.force.row(at), inward = samples.point_normal.row(samples.point[row]);
    reason += fmt::format(": its force stands {:.0f} degrees off the press",
                          std::acos(force.normalized().dot(inward)) * 180 / std::numbers::pi);
  }
  if (!samples.step_check.empty() && samples.step_check[row] != StepCheck::none &&
      samples.status[row] != RowStatus::inverted)
    reason +=
        ": " + std::string(kStepCheckNames[static_cast<std::size_t>(samples.step_check[row])]);
  return reason;
}

}  // namespace

std::size_t say_force_errors(const Samples& samples, double wanted) {
  std::vector<std::vector<fem::PointRow>> rows(static_cast<std::size_t>(samples.points()));
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    fem::PointRow row;
    row.status = samples.status[static_cast<std::size_t>(i)];
    row.force = samples.force.row(i);
    row.force_error = samples.force_error[i];
    rows[static_cast<std::size_t>(samples.point[static_cast<std::size_t>(i)])].push_back(row);
  }
  std::vector<double> errors;  // of points that have one
  for (const auto& of_point : rows)
    if (const double error = fem::achieved_error(of_point); std::isfinite(error))
      errors.push_back(error);
  if (rows.empty()) return 0;
  std::sort(errors.begin(), errors.end());
  const auto within = static_cast<std::size_t>(
      std::upper_bound(errors.begin(), errors.end(), wanted) - errors.begin());
  const std::size_t missed = wanted > 0 ? rows.size() - within : 0;
  const std::string target = wanted > 0
                                 ? fmt::format("; {:.2g} % was asked for, {} of {} points have it",
                                               100 * wanted, within, rows.size())
                                 : "";
  if (errors.empty())
    say("  no point has rows with an estimate of their force error{}", target);
  else
    say("  force error by the rows' own estimate, largest of a point: median {:.2g} %, worst "
        "{:.2g} %{}",
        100 * errors[errors.size() / 2], 100 * errors.back(), target);
  return missed;
}

std::size_t list_bad_experiments(const Samples& samples) {
  // First bad row of each experiment, with the first reason that is not a consequence.
  std::map<std::int32_t, std::pair<Eigen::Index, std::size_t>> bad;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[static_cast<std::size_t>(row)] != RowStatus::good)
      ++bad.try_emplace(samples.experiment[static_cast<std::size_t>(row)], row, 0)
            .first->second.second;
  std::size_t listed = 0;
  for (const auto& [experiment, place] : bad) {
    if (listed++ == kListed) {
      say_failed("  and {} more experiments with rows that are not good", bad.size() - kListed);
      break;
    }
    const auto row = static_cast<std::size_t>(place.first);
    const Vec3 at = samples.point_position.row(samples.point[row]);
    say_failed("  not good: {} at ({:.1f}, {:.1f}, {:.1f}) mm, {} from {:.2f} mm on: {} ({} rows)",
               samples.point_name[static_cast<std::size_t>(samples.point[row])], 1e3 * at[0],
               1e3 * at[1], 1e3 * at[2],
               samples.kind[row] == ExperimentKind::press  ? "press"
               : samples.kind[row] == ExperimentKind::drag ? "drag"
                                                           : "path",
               1e3 * samples.deflection.row(place.first).norm(), reason_of(samples, row),
               place.second);
  }
  return bad.size();
}

namespace {

constexpr double kFarthestRatio = 0.05;  // of the body's diagonal

}  // namespace

TestPoints place_points(const PointTable& points, const Surface& surface,
                        const std::string& where) {
  const fem::SmoothSurface smooth(surface);
  const double farthest_m = kFarthestRatio * extent_m(surface.vertices).norm();
  TestPoints placed;
  placed.position.resize(points.position.rows(), 3);
  placed.normal.resize(points.position.rows(), 3);
  for (Eigen::Index i = 0; i < points.position.rows(); ++i) {
    const Vec3 given = points.position.row(i);
    const fem::SurfaceHit hit = smooth.closest(given);
    if (!(hit.distance_m <= farthest_m)) {
      const auto unit = misread_unit(Points(given.transpose()), surface);
      throw Error(
          fmt::format("{}: point {}", where, i + 1),
          fmt::format("({}, {}, {}) m lies {:.3g} m off the surface", given[0], given[1], given[2],
                      hit.distance_m),
          fmt::format(
              "{}Give points within {:.3g} m of it, in metres and in the frame of the scaled mesh.",
              unit ? fmt::format("In {} it would lie at the body. ", *unit) : "", farthest_m));
    }
    placed.position.row(i) = hit.on_facet;
    placed.normal.row(i) = points.normal.rows() ? Vec3(points.normal.row(i)) : Vec3(-hit.normal);
    placed.name.push_back(fmt::format("p{:04}", i + 1));
  }
  return placed;
}

void refuse_same_place(const Points& position, const std::string& where) {
  std::map<std::array<double, 3>, Eigen::Index> seen;
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    const auto [other, is_new] =
        seen.try_emplace({position(i, 0), position(i, 1), position(i, 2)}, i);
    if (!is_new)
      throw Error(fmt::format("{}: point {}", where, i + 1),
                  fmt::format("is at the place of point {}", other->second + 1),
                  "Leave one of them out.");
  }
}

PlacedPaths place_paths(const std::vector<PathInTable>& paths, const Surface& surface,
                        const std::string& where) {
  const double size_m = extent_m(surface.vertices).norm();
  PointTable table;
  table.position.resize(static_cast<Eigen::Index>(paths.size()), 3);
  PlacedPaths placed;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    table.position.row(static_cast<Eigen::Index>(i)) = paths[i].point;
    placed.paths.push_back({static_cast<int>(i), paths[i].deflection});
    const double most_m = paths[i].deflection.rowwise().norm().maxCoeff();
    if (most_m > size_m)
      throw Error(fmt::format("{}: path {}", where, paths[i].name),
                  fmt::format("goes {:.3g} m from its point, and the body measures {:.3g} m",
                              most_m, size_m),
                  "Give dx_m,dy_m,dz_m in metres, from the point on.");
  }
  placed.points = place_points(table, surface, where);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Vec3 inward = placed.points.normal.row(static_cast<Eigen::Index>(i)).array() + 0.0;
    if (!((paths[i].deflection * inward).maxCoeff() > 0))
      throw Error(fmt::format("{}: path {}", where, paths[i].name), "never goes into the body",
                  fmt::format("Inward is ({:.2g}, {:.2g}, {:.2g}) there.", inward[0], inward[1],
                              inward[2]));
    placed.points.name[i] = paths[i].name;
  }
  return placed;
}

}  // namespace palpate::tools
