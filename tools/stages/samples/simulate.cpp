#include "tools/stages/samples/experiment_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "libfem/solve/experiments/simulate.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;  // experiments named before "and N more"

}  // namespace

bool relaxes(const Scene& scene) {
  const auto has_branches = [](const fem::MaterialParameters& material) {
    return material.relaxation.branches() > 0;
  };
  return (scene.material && has_branches(*scene.material)) ||
         std::ranges::any_of(scene.inclusions, has_branches, &InclusionSection::material);
}

bool softens(const Scene& scene) {
  const auto is_soft = [](const fem::MaterialParameters& m) { return m.softening.is_any(); };
  return (scene.material && is_soft(*scene.material)) ||
         std::ranges::any_of(scene.inclusions, is_soft, &InclusionSection::material);
}

Eigen::Index surface_columns(const Scene& scene, const Body& body) {
  const Eigen::Index vertices = body.surface.vertices.rows();
  // A row of the motion takes some 3 bytes a vertex; a finer surface is not kept.
  return scene.experiments.surface && vertices <= 20000 ? 3 * vertices : 0;
}

void add_body_and_probe(Samples& samples, const fem::SimulatorOf& simulator,
                        const ExperimentList& list) {
  const fem::SimulationSetup& setup = simulator(Experiment{}).setup();
  samples.probe = setup.probe;
  for (const Experiment& one : list.experiments) {
    const auto number = static_cast<std::size_t>(one.probe_number);
    if (number == 0) continue;
    samples.other_probes.resize(std::max(samples.other_probes.size(), number));
    samples.other_probes[number - 1] = simulator(one).setup().probe;
  }
  const fem::Material material = fem::make_material(setup.materials.front(), "[material]");
  samples.poisson = material.law->small_strain(material.constants).poisson();
}

Relaxation contact_relaxation(const Scene& scene, const Body& body, const Samples& samples) {
  if (!scene.material || scene.material->relaxation.branches() == 0) return {};
  TestPoints first;
  const Eigen::Index points = std::min<Eigen::Index>(3, samples.points());
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
  fem::SimulationSetup setup = make_setup(scene, body);
  setup.keeps_surface = surface_columns(scene, body) > 0;
  return fem::Simulator(std::move(setup));
}

namespace {

// "rejected: overlaps"
std::string reason_of(const Samples& samples, std::size_t row) {
  std::string reason(name_of(samples.status[row]));
  if (samples.status[row] == RowStatus::wedged) {
    const auto at = static_cast<Eigen::Index>(row);
    const Vec3 force = samples.force.row(at), inward = samples.point_normal.row(samples.point[row]);
    reason += fmt::format(": its force stands {:.0f} degrees off the press",
                          std::acos(force.normalized().dot(inward)) * 180 / std::numbers::pi);
  }
  if (!samples.step_check.empty() && samples.step_check[row] != StepCheck::none &&
      samples.status[row] != RowStatus::inverted)
    reason += ": " + std::string(name_of(samples.step_check[row]));
  return reason;
}

}  // namespace

void say_force_errors(const Samples& samples, double wanted) {
  std::vector<std::vector<Eigen::Index>> rows(samples.points());
  for (Eigen::Index row = 0; row < samples.rows(); ++row) rows[samples.point[row]].push_back(row);
  std::vector<double> errors;  // of points that have one
  for (const auto& of_point : rows)
    if (const double error = fem::achieved_error(samples, of_point); std::isfinite(error))
      errors.push_back(error);
  if (rows.empty()) return;
  std::sort(errors.begin(), errors.end());
  const auto within = static_cast<std::size_t>(
      std::upper_bound(errors.begin(), errors.end(), wanted) - errors.begin());
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
}

std::size_t list_bad_experiments(const Samples& samples) {
  // First bad row of each experiment, with the first reason that is not a consequence.
  std::map<std::int32_t, std::pair<Eigen::Index, std::size_t>> bad;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[row] != RowStatus::good)
      ++bad.try_emplace(samples.experiment[row], row, 0).first->second.second;
  std::size_t listed = 0;
  for (const auto& [experiment, place] : bad) {
    if (listed++ == kListed) {
      say_failed("  and {} more experiments with rows that are not good", bad.size() - kListed);
      break;
    }
    const auto row = static_cast<std::size_t>(place.first);
    say_failed("  not good: {} at {}, {} from {:.2f} mm on: {} ({} rows)",
               samples.point_name[samples.point[row]],
               in_mm(samples.point_position.row(samples.point[row])), name_of(samples.kind[row]),
               1e3 * samples.deflection.row(place.first).norm(), reason_of(samples, row),
               place.second);
  }
  return bad.size();
}

namespace {

struct Pressed {
  std::size_t point = 0;
  double force_N = 0;
  double lean = 0;  // of the deepest row: tangential over normal force
  bool is_whole = true;
};

std::vector<Pressed> deepest_rows(const Samples& presses) {
  std::vector<Pressed> out(presses.points());
  for (std::size_t p = 0; p < out.size(); ++p) out[p].point = p;
  for (Eigen::Index row = 0; row < presses.rows(); ++row) {
    Pressed& point = out[presses.point[row]];
    if (presses.status[row] != RowStatus::good) point.is_whole = false;
    const Vec3 force = presses.force.row(row),
               normal = presses.point_normal.row(presses.point[row]);
    if (!(force.norm() > point.force_N)) continue;
    point.force_N = force.norm();
    const double pressed_N = force.dot(normal);
    point.lean = pressed_N > 0 ? (force - pressed_N * normal).norm() / pressed_N
                               : std::numeric_limits<double>::infinity();
  }
  std::erase_if(out, [](const Pressed& point) { return !(point.force_N > 0); });
  return out;
}

}  // namespace

std::vector<std::size_t> points_to_drag(const Samples& presses) {
  std::vector<Pressed> points = deepest_rows(presses);
  std::ranges::stable_sort(points, {}, &Pressed::force_N);
  const std::size_t groups = std::min(kFirstDrags, points.size());
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < groups; ++k) {
    const auto at = [&](std::size_t group) {
      return points.begin() + static_cast<std::ptrdiff_t>(group * points.size() / groups);
    };
    const auto rank = [&](const Pressed& point) {
      return std::pair(!point.is_whole, k + 1 < groups ? point.lean : -point.force_N);
    };
    out.push_back(std::ranges::min_element(at(k), at(k + 1), {}, rank)->point);
  }
  std::ranges::sort(out);
  return out;
}

std::vector<std::size_t> points_beyond_drags(const Samples& presses,
                                             const std::vector<std::size_t>& dragged) {
  const std::size_t most =
      std::min(static_cast<std::size_t>(presses.points()) / kPointsPerDrag, kLastDrags);
  std::vector<Pressed> points = deepest_rows(presses);
  // Rings of a drag are those of a flat surface up to a tenth of tangential over normal force.
  std::erase_if(points, [](const Pressed& point) { return !point.is_whole || point.lean > 0.1; });
  std::vector<double> known;
  for (const Pressed& point : points)
    if (std::ranges::find(dragged, point.point) != dragged.end())
      known.push_back(std::log(point.force_N));
  const auto away = [&](const Pressed& point) {
    double least = std::numeric_limits<double>::infinity();
    for (const double force : known)
      least = std::min(least, std::abs(std::log(point.force_N) - force));
    return least;
  };
  std::vector<std::size_t> out;
  while (!points.empty() && !known.empty() && out.size() < most) {
    const auto furthest = std::ranges::max_element(points, {}, away);
    // Forces further apart than this factor say nothing of each other's rings.
    if (!(away(*furthest) > std::log(1.1))) break;
    known.push_back(std::log(furthest->force_N));
    out.push_back(furthest->point);
  }
  return out;
}

}  // namespace palpate::tools
