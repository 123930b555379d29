#include "tools/setup/propose.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "tools/scene/tissues.hpp"
#include "tools/stages/body/plausibility.hpp"

namespace palpate::tools {
namespace {

constexpr double kSmallestOrgan_m = 0.03, kLargestOrgan_m = 1;
constexpr double kHeldShare = 0.25;      // of the surface's area; less and the organ sways
constexpr double kFacing = 0.7;          // cosine to a side of what lies flat on it
constexpr double kWindowShare = 0.22;    // window's radius over the extents across
constexpr double kProbeShare = 1.0 / 8;  // of the thickness; presses go one radius deep
constexpr double kLargestProbe_m = 0.01;

struct BoxSide {
  int axis = 2;
  double sign = -1;
  std::string name() const { return fmt::format("{}{}", sign < 0 ? '-' : '+', "xyz"[axis]); }
  Vec3 outward() const { return sign * Vec3::Unit(axis); }
};

BoxSide side_of(std::string_view name) { return {name[1] - 'x', name[0] == '-' ? -1.0 : 1.0}; }

// Two digits, so that a reader sees a choice and no measurement; in mm.
double rounded_mm(double length_m) {
  const double mm = 1e3 * length_m;
  const double step = std::pow(10, std::floor(std::log10(mm)) - 1);
  return std::round(mm / step) * step;
}

// Where a side's slab begins along its outward direction, and the area [m^2] in it that faces it.
struct Slab {
  double border_m = 0, resting_m2 = 0;
};

Slab slab_of(const Surface& surface, const BoxSide& side) {
  std::vector<std::array<double, 3>> faces;  // height, area, area where it faces the side
  double total = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = surface.triangles.row(f);
    const Vec3 a = surface.vertices.row(corner[0]), b = surface.vertices.row(corner[1]),
               c = surface.vertices.row(corner[2]);
    const Vec3 normal = (b - a).cross(c - a) / 2;
    const double area = normal.norm();
    const bool faces_it = normal.dot(side.outward()) > kFacing * area;
    faces.push_back({side.outward().dot(a + b + c) / 3, area, faces_it ? area : 0});
    total += area;
  }
  std::sort(faces.begin(), faces.end(), std::greater<>());
  Slab slab;
  double held = 0;
  for (const auto& [height, area, resting] : faces) {
    slab.border_m = height;
    slab.resting_m2 += resting;
    if ((held += area) >= kHeldShare * total) break;
  }
  return slab;
}

// Where a line through the middle of the body, against the held side, leaves it, and how thick the
// body is there.
struct Window {
  Vec3 centre = Vec3::Zero();
  double thickness_m = 0, radius_m = 0;
};

Window window_opposite(const Surface& surface, const BoxSide& held) {
  const BoxTree boxes = triangle_boxes(surface);
  const Vec3 up = -held.outward();
  const Vec3 low = surface.vertices.colwise().minCoeff(),
             high = surface.vertices.colwise().maxCoeff();
  const Vec3 middle = surface.vertices.colwise().mean();
  Vec3 above = middle;
  above[held.axis] = up[held.axis] > 0 ? high[held.axis] : low[held.axis];
  above += 1e-3 * (high - low).norm() * up;
  // The nearest place of the surface stands in where the line misses it, as on a ring.
  const auto hit = ray_distance_m(surface, boxes, above, -up, 0);
  const Vec3 centre =
      hit ? Vec3(above - *hit * up) : closest_point(surface, boxes, above)->position;
  const double skip = 1e-6 * (high - low).norm();
  const auto through = ray_distance_m(surface, boxes, centre - skip * up, -up, skip);
  const double thickness_m = through ? *through : (high - low).minCoeff();
  Vec3 across = high - low;
  across[held.axis] = std::numeric_limits<double>::infinity();
  return {centre, thickness_m, kWindowShare * across.minCoeff()};
}

// Share of the window's area that looks away from the held side, so that a tool can press on it.
double facing_share(const Surface& surface, const BoxSide& held, const Window& window) {
  double all = 0, facing = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = surface.triangles.row(f);
    const Vec3 a = surface.vertices.row(corner[0]), b = surface.vertices.row(corner[1]),
               c = surface.vertices.row(corner[2]);
    if (((a + b + c) / 3 - window.centre).norm() > window.radius_m) continue;
    const Vec3 normal = (b - a).cross(c - a) / 2;
    all += normal.norm();
    if (-normal.dot(held.outward()) > kFacing * normal.norm()) facing += normal.norm();
  }
  return all > 0 ? facing / all : 0;
}

// The side to hold: what lies in its slab is flat, and the window opposite can be pressed on.
BoxSide best_side(const Surface& surface) {
  BoxSide best;
  double highest = -1;
  const double held_m2 = kHeldShare * area_m2(surface);
  for (const std::string_view name : kSides) {
    const BoxSide side = side_of(name);
    const double score = facing_share(surface, side, window_opposite(surface, side)) +
                         0.5 * slab_of(surface, side).resting_m2 / held_m2;
    if (score > highest + 0.05) {
      best = side;
      highest = score;
    }
  }
  return best;
}

// wrap_m: what it was wrapped with, 0 where it was closed without.
Mended mended(const Surface& surface, const std::string& mesh, double& wrap_m) {
  try {
    return mend_surface(surface, {}, mesh);
  } catch (const Error&) {
    MendOptions options;
    options.wrap = true;
    options.wrap_alpha_m = wrap_m = extent_m(surface.vertices).norm() / 50;
    return mend_surface(surface, options, mesh);
  }
}

std::string material_text(const Tissue& tissue) {
  const std::string deviation =
      tissue.deviation_Pa > 0 ? fmt::format(" +- {:.3g}", tissue.deviation_Pa / 1e3) : "";
  return fmt::format(
      "[material]                      # {}: {:.4g}{} kPa, {}\n"
      "law = \"{}\"             # {}, doi:{}\n"
      "young = \"{:.4g} kPa\"\n"
      "poisson = {}\n",
      tissue.name, tissue.young_Pa / 1e3, deviation, tissue.measured, tissue.law, tissue.source,
      tissue.doi, tissue.young_Pa / 1e3, tissue.poisson);
}

double metres_in(const std::string& unit) {
  const auto named = unit_factor(unit, Dimension::length);
  const auto metres = named ? named : parse_quantity(unit, Dimension::length);
  if (!metres || !(*metres > 0))
    throw Error(
        "--unit", fmt::format("\"{}\" is no length", unit),
        "Use one of " + known_units(Dimension::length) + ", or a length such as \"110 mm\".");
  return *metres;
}

void check_side(const std::string& name) {
  if (std::find(kSides.begin(), kSides.end(), name) == kSides.end())
    throw Error("--held", fmt::format("\"{}\" is no side", name),
                fmt::format("Use one of {}.", fmt::join(kSides, ", ")));
}

// A TOML string: what JSON escapes in a file's name, and how, TOML understands.
std::string quoted(const std::filesystem::path& path) {
  using Json = nlohmann::json;
  return Json(path.string()).dump(-1, ' ', false, Json::error_handler_t::replace);
}

// wrap_m: 0 where the surface needs none.
std::string body_text(const std::filesystem::path& mesh, const std::string& unit,
                      const SurfaceFacts& facts, double wrap_m, const BoxSide& held,
                      double border_m) {
  const std::string wrap =
      wrap_m > 0 ? fmt::format(
                       "wrap = \"{:.3g} mm\"               # it has gaps; narrower ones are "
                       "closed\n",
                       rounded_mm(wrap_m))
                 : "";
  return fmt::format(
      "# {}, {}. Made by `palpate new`: every line is a proposal.\n"
      "# Next: palpate check THIS_FILE, then palpate run THIS_FILE -o out\n\n"
      "[body]\n"
      "surface = {}\n"
      "length_unit = \"{}\"              # mesh files carry none\n"
      "{}"
      "fixed = [ {{ {} = {{ axis = \"{}\", at = \"{:.4g} mm\" }} }} ]   # what the body rests "
      "on\n\n",
      mesh.filename().string(), size_in_words(facts.extent_m, facts.volume_m3), quoted(mesh), unit,
      wrap, held.sign < 0 ? "below" : "above", "xyz"[held.axis], 1e3 * border_m);
}

std::string experiments_text(const Window& window) {
  const double radius_mm = rounded_mm(window.radius_m);
  const double probe_mm = rounded_mm(std::min(kProbeShare * window.thickness_m, kLargestProbe_m));
  return fmt::format(
      "\n[probe]                         # the tool's tip\n"
      "shape = \"sphere\"\n"
      "radius = \"{:.3g} mm\"\n"
      "friction = 0.2                  # wet tissue on steel: 0.02 to 0.3\n\n"
      "[experiments]\n"
      "test_points = \"auto\"            # placed where prediction fails\n"
      "tolerance = 0.07                # relative force error at new points, p95\n"
      "budget = 200                    # most points simulated, a second or two each\n"
      "region = {{ sphere = {{ center = [\"{:.4g} mm\", \"{:.4g} mm\", \"{:.4g} mm\"], radius = "
      "\"{:.3g} mm\" }} }}   # the window that is touched\n"
      "depth = \"{:.3g} mm\"\n"
      "press_steps = 7\n"
      "drag_depths = [\"{:.3g} mm\", \"{:.3g} mm\"]\n"
      "drag_distance = \"{:.3g} mm\"      # long enough to slip\n"
      "drag_directions = 1\n"
      "drag_steps = 7\n\n"
      "[validate]\n"
      "points = 12                     # held-out places that the statement compares\n",
      probe_mm, 1e3 * window.centre[0], 1e3 * window.centre[1], 1e3 * window.centre[2], radius_mm,
      probe_mm, 0.4 * probe_mm, 0.85 * probe_mm, 0.8 * probe_mm);
}

}  // namespace

std::string likely_unit(const Vec3& extent) {
  for (const char* unit : {"mm", "cm", "m", "um"}) {
    const double size_m = extent.maxCoeff() * unit_factor(unit, Dimension::length).value();
    if (size_m >= kSmallestOrgan_m && size_m <= kLargestOrgan_m) return unit;
  }
  return "mm";
}

ProposedScene propose_scene(const std::filesystem::path& mesh, const Surface& in_file,
                            const SceneChoices& choices) {
  const Tissue& tissue = find_tissue(choices.tissue, "--tissue");
  const std::string unit =
      choices.unit.empty() ? likely_unit(extent_m(in_file.vertices)) : choices.unit;
  if (!choices.held.empty()) check_side(choices.held);

  ProposedScene scene;
  Surface scaled = in_file;
  scaled.vertices *= metres_in(unit);
  double wrap_m = 0;
  Mended closed = mended(scaled, mesh.string(), wrap_m);
  const Surface& surface = closed.surface;
  const SurfaceFacts facts = surface_facts(surface);
  for (const std::string& change : closed.changes) scene.notes.push_back("mended: " + change);
  scene.notes.push_back(
      fmt::format("in {} it measures {}", unit, size_in_words(facts.extent_m, facts.volume_m3)));
  if (facts.components > 1)
    scene.notes.push_back(fmt::format(
        "it has {} pieces; those that touch nothing held will float away", facts.components));

  const BoxSide held = choices.held.empty() ? best_side(surface) : side_of(choices.held);
  const Window window = window_opposite(surface, held);
  scene.notes.push_back(fmt::format(
      "held on its {} side; the window lies opposite, where the body is {:.3g} mm thick",
      held.name(), 1e3 * window.thickness_m));
  scene.text =
      body_text(mesh, unit, facts, wrap_m, held, held.sign * slab_of(surface, held).border_m) +
      material_text(tissue) + experiments_text(window);
  return scene;
}

}  // namespace palpate::tools
