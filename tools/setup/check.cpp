#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>

#include "libfem/materials/materials.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/perception.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/units.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/console.hpp"
#include "tools/setup/check.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

constexpr double kUsefulError = 0.03;  // of a row's force; more hides what a fit can do

double thread_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Vec3 across(const Vec3& vector, const Vec3& normal) { return vector - vector.dot(normal) * normal; }

// Sticking and slipping rows of the drags on their outward strokes. A drag slips where its
// stiffness has fallen to 0.6 of that of its first row.
void count_drags(const SampleRows& rows, const Vec3& normal, Trial& trial) {
  std::map<int, Eigen::Index> first;
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    if (rows.kind[row] != ExperimentKind::drag || rows.status[row] != RowStatus::good) continue;
    const auto [start, is_first] = first.try_emplace(rows.experiment[row], row);
    const auto distance = [&](Eigen::Index of) {
      return across(rows.deflection.row(of), normal).norm();
    };
    if (!is_first && distance(row) < distance(row - 1)) continue;
    const auto stiffness = [&](Eigen::Index of) {
      return distance(of) > 0 ? across(rows.force.row(of), normal).norm() / distance(of) : 0;
    };
    const double initial = stiffness(start->second);
    if (!(initial > 0)) continue;
    (stiffness(row) < 0.6 * initial ? trial.slipping : trial.sticking) += 1;
  }
}

Trial simulate_middle_point(const Scene& scene, const Body& body) {
  const Eigen::Index point = middle_point(scene, body);
  Trial trial;
  trial.point = body.test_points.name[point];
  trial.position = body.test_points.position.row(point);
  const Vec3 normal = body.test_points.normal.row(point);
  const fem::Simulator simulator(make_setup(scene, body));
  const double started_s = thread_seconds();
  Progress progress;
  progress.is_stopped = [] { return is_interrupted(); };
  say("  trial at {}: a press with its drags", trial.point);
  const fem::PointRows done =
      simulator.press_and_drag(trial.position, normal, experiments_of(scene), progress);
  trial.cpu_s = thread_seconds() - started_s;
  simulator.press_quickly(trial.position, normal, experiments_of(scene), progress);
  trial.quick_s = thread_seconds() - started_s - trial.cpu_s;
  trial.held_share = simulator.held_share(trial.position, normal, experiments_of(scene), progress);
  if (!done.is_complete) throw Interrupted("check: the trial was not finished");
  trial.nodes = done.cost.nodes;
  trial.rows = done.rows();
  trial.force_error = fem::achieved_error(done);
  for (Eigen::Index row = 0; row < done.rows(); ++row) {
    if (done.kind[row] == ExperimentKind::press) ++trial.pressed;
    if (done.status[row] == RowStatus::wedged) ++trial.wedged;
    if (done.status[row] != RowStatus::good) continue;
    ++trial.good;
    const double depth_m = done.deflection.row(row).dot(normal);
    if (done.kind[row] == ExperimentKind::press && depth_m > trial.depth_m) {
      trial.depth_m = depth_m;
      trial.force_N = done.force.row(row).dot(normal);
      trial.sway_m = symmetric_eigen(done.sway_m_N).values[2] * done.force.row(row).norm();
    }
  }
  // Hertz with the contact radius a of the probe: F = 4/3 E* a d.
  const fem::Material material = fem::make_material(*scene.material, "[material]");
  const fem::SmallStrain small = material.law->small_strain(material.constants);
  trial.half_space_N = 4.0 / 3 * small.young_Pa() / (1 - small.poisson() * small.poisson()) *
                       scene.probe.rigid->contact_radius_m(trial.depth_m) * trial.depth_m;
  count_drags(done, normal, trial);
  return trial;
}

}  // namespace

Trial try_middle_point(const Scene& scene, const Body& body) {
  const auto trial = std::make_shared<Trial>();
  run_abandonably([trial, scene, body] { *trial = simulate_middle_point(scene, body); },
                  "check: the trial was not finished");
  return *trial;
}

namespace {

// Of the placement; 0 where test points are as the body has them.
int placed_points(const Scene& scene, const Body& body) {
  if (!scene.experiments.placement) return 0;
  int candidates = 0;
  for (std::size_t v = 0; v < body.is_reachable.size(); ++v)
    candidates += body.is_reachable[v] && body.in_region[v];
  return std::min(scene.experiments.placement->budget, std::max(candidates, kFirstPoints));
}

int held_out_experiments(const Scene& scene) {
  return scene.validate.points + scene.validate.presses();
}

}  // namespace

int points_of_run(const Scene& scene, const Body& body) {
  const int own = scene.experiments.placement ? placed_points(scene, body)
                                              : static_cast<int>(body.test_points.position.rows());
  return own + held_out_experiments(scene);
}

double cpu_of_run_s(const Scene& scene, const Body& body, const Trial& trial) {
  const int points = points_of_run(scene, body), held_out = held_out_experiments(scene);
  if (!scene.experiments.placement || trial.rows == 0) return points * trial.cpu_s;
  return (kFirstDrags + held_out) * trial.cpu_s + (points - held_out) * trial.quick_s;
}

std::vector<std::string> advice(const Scene& scene, const Trial& trial) {
  std::vector<std::string> out;
  const Experiments& each = scene.experiments.each;
  if (trial.wedged > 0)
    out.push_back(
        fmt::format("{} of {} rows of the press are wedged: their force stands more than 45 "
                    "degrees off the press, as in a groove narrower than the tool. Move the window "
                    "(region), or take a smaller probe.",
                    trial.wedged, trial.pressed));
  if (trial.good + trial.wedged < trial.rows)
    out.push_back(
        fmt::format("{} of {} rows are not good, the press ends at {:.3g} mm: press less deep "
                    "(depth), or in smaller steps (press_steps, drag_steps).",
                    trial.rows - trial.good - trial.wedged, trial.rows, 1e3 * trial.depth_m));
  if (!std::isfinite(trial.force_error) || trial.force_error > kUsefulError)
    out.push_back(fmt::format(
        "rows state a force error of {:.2g} %: set force_tolerance = {} in [experiments].",
        100 * trial.force_error, kUsefulError));
  // Softer inclusions take less. A wall bends wherever it is held.
  const bool is_soft =
      trial.force_N < 0.4 * trial.half_space_N && !scene.body.wall_m && !scene.body.cavity;
  if (const auto held = validation::advice_on_held_part(trial.held_share)) out.push_back(*held);
  if (is_soft)
    out.push_back(
        fmt::format("the press has {:.2g} N where a body that stays in its place has {:.2g}: the "
                    "organ sways. Hold more of it, or nearer to the window (fixed).",
                    trial.force_N, trial.half_space_N));
  else if (trial.force_N < perception().force_floor_N)
    out.push_back(
        fmt::format("the press ends at {:.2g} N, less than a hand notices: press deeper, or check "
                    "the units of mesh and material.",
                    trial.force_N));
  // Livers, a hand, a cow, the dragon and blocks sway by 0.2 to 0.9 of the depth, an elephant held
  // behind by 1.6 (p95 3.6 %), a figure that stands on two feet by 14 (p95 65 %).
  if (!is_soft && trial.sway_m > 3 * trial.depth_m)
    out.push_back(
        fmt::format("the force of the press, sideways, moves the body as a whole by {:.2g} mm "
                    "where the tool went in by {:.2g}: the organ sways, and slides will be off by "
                    "10 % or more. Hold more of it, or nearer to the window (fixed).",
                    1e3 * trial.sway_m, 1e3 * trial.depth_m));
  if (each.drag_directions > 0 && scene.probe.spec.friction > 0) {
    if (trial.slipping == 0)
      out.push_back(fmt::format("no drag slips: make drag_distance {:.2g} mm or more.",
                                2e3 * each.drag_distance_m));
    if (trial.sticking < 2)
      out.push_back(
          fmt::format("drags slip at once: make drag_steps {} or more.", 2 * each.drag_steps));
  }
  return out;
}

namespace {

// The power of ten, as a unit, that makes a length of a file an organ's.
std::string likely_power(double extent) {
  const double power_m = std::pow(10, std::round(std::log10(0.15 / extent)));
  for (const char* name : {"m", "dm", "cm", "mm", "um"})
    if (std::abs(*unit_factor(name, Dimension::length) / power_m - 1) < 1e-6) return name;
  return fmt::format("{:.3g} mm", 1e3 * power_m);
}

// Largest extent of each border of a surface, of those that hang together over their vertices.
double widest_border_m(const Surface& surface) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> sides;  // triangles of an edge
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<std::int32_t> next;  // border edges as a surface of flat triangles, for its patches
  std::vector<char> is_border(surface.vertices.rows(), 0);
  Surface lines{surface.vertices, {}};
  for (const auto& [edge, triangles] : sides)
    if (triangles == 1) next.insert(next.end(), {edge.first, edge.second, edge.second});
  lines.triangles.resize(next.size() / 3, 3);
  for (std::size_t i = 0; i < next.size(); ++i) {
    lines.triangles(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = next[i];
    is_border[next[i]] = 1;
  }
  double widest_m = 0;
  for (const auto& border : patches_of(lines, is_border))
    widest_m =
        std::max(widest_m, extent_m(Points(surface.vertices(border, Eigen::all))).maxCoeff());
  return widest_m;
}

}  // namespace

std::string likely_unit(const Vec3& extent) {
  for (const char* unit : {"mm", "cm", "m", "um"}) {
    const double size_m = extent.maxCoeff() * unit_factor(unit, Dimension::length).value();
    if (size_m >= 0.03 && size_m <= 1) return unit;
  }
  return extent.maxCoeff() > 0 ? likely_power(extent.maxCoeff()) : "mm";
}

std::optional<std::string> doubt_of_size(const Vec3& extent, double unit_m) {
  const double size_m = unit_m * extent.maxCoeff();
  // A thyroid has 5 cm, a muscle of the thigh 50.
  if (size_m >= 0.04 && size_m <= 0.6) return std::nullopt;
  const std::string unit = likely_power(extent.maxCoeff());
  const auto named = unit_factor(unit, Dimension::length);
  const double other_m = named ? *named : *parse_quantity(unit, Dimension::length);
  return fmt::format(
      "it measures {}, {} than most organs. If that is not so, give its unit: --unit \"{}\" makes "
      "it {}",
      size_in_words(unit_m * extent, 0), size_m < 0.04 ? "smaller" : "larger", unit,
      size_in_words(other_m * extent, 0));
}

std::optional<std::string> doubt_of_lid(const Surface& in_file,
                                        const std::vector<std::string>& changes) {
  if (std::ranges::none_of(changes, [](const std::string& c) { return c.starts_with("filled "); }))
    return std::nullopt;
  MendOptions open;
  open.allow_open = true;
  Surface welded;
  try {
    welded = mend_surface(in_file, open, "").surface;
  } catch (const Error&) {
    return std::nullopt;  // a soup, whose borders are none
  }
  const double size_m = extent_m(in_file.vertices).maxCoeff(), lid_m = widest_border_m(welded);
  if (lid_m < 0.5 * size_m) return std::nullopt;
  return fmt::format(
      "[body]: the surface is open, and closed by a lid {:.3g} mm wide on a body of {:.3g} mm. "
      "Does the organ end there, or is a part of it missing? Where it is missing, close the "
      "surface in a mesh editor",
      1e3 * lid_m, 1e3 * size_m);
}

std::vector<std::string> doubts_of_body(const Scene& scene,
                                        const std::vector<std::string>& changes) {
  std::vector<std::string> doubts;
  if (!scene.body.surface) return doubts;
  const auto is_wrapped = [](const std::string& c) { return c.find("wrapped") != c.npos; };
  if (scene.body.wrap_m && std::ranges::none_of(changes, is_wrapped))
    doubts.push_back("[body]: wrap changes nothing, for the surface can be mended without");
  if (changes.empty()) return doubts;
  if (const auto lid =
          doubt_of_lid(read_surface(*scene.body.surface, scene.body.length_unit_m), changes))
    doubts.push_back(*lid);
  return doubts;
}

}  // namespace palpate::tools
