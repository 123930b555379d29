#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "libfem/materials/materials.hpp"
#include "libfem/mesh/fill/fill_volume.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "tools/console.hpp"
#include "tools/scene/tissues.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListedParts = 3;
// Tets over what the edge length asks for. Organs have 0.5 to 2.5.
constexpr double kManyTimes = 8;
constexpr int kSamplesAcross = 28;
constexpr double kWhole = 0.99;  // share inside that passes without a word, for sampling's sake

using Warnings = std::vector<std::string>;

void check_material(const fem::MaterialParameters& material, const std::string& where,
                    Warnings& warnings) {
  const fem::Material made = fem::make_material(material, where);
  const fem::SmallStrain at_rest = made.law->small_strain(made.constants);
  const double young = at_rest.young_Pa();
  if (at_rest.poisson() < 0)
    warnings.push_back(
        fmt::format("{}: with a Poisson's ratio of {:.2g} it grows thinner under a press, which no "
                    "tissue does; 0.4 to 0.499 is usual.",
                    where, at_rest.poisson()));
  if (young < 50)  // gels go down to 100 Pa
    warnings.push_back(
        fmt::format("{}: its stiffness at rest is {:.3g} Pa, softer than any tissue. Numbers "
                    "without a unit are in Pa: was \"{:.3g} kPa\" meant?",
                    where, young, young));
  if (young > 5e6) {  // cartilage and silicones have a few MPa
    const auto [soft, stiff] = std::ranges::minmax(tissues(), {}, &Tissue::young_Pa);
    const double in_unit = young / (young < 1e9 ? 1e6 : 1e9);
    warnings.push_back(fmt::format(
        "{}: its stiffness at rest is {:.3g} {}, and no soft tissue is that stiff: `palpate new` "
        "has {:.4g} kPa ({}) to {:.4g} kPa ({}). Was \"{:.3g} kPa\" meant?",
        where, in_unit, young < 1e9 ? "MPa" : "GPa", 1e-3 * soft.young_Pa, soft.name,
        1e-3 * stiff.young_Pa, stiff.name, in_unit));
  }
}

// Memory of a press [GB], as N^1.5 over N quadratic nodes, 1.4 a tet: 12.6 GB were seen on 183,855
// tets.
double memory_GB(double tets) { return 1e-9 * 98 * std::pow(1.4 * tets, 1.5); }

void check_mesh_size(const Scene& scene, const Body& body, Warnings& warnings) {
  const auto tets = static_cast<double>(body.volume.tets.rows());
  const double volume = volume_m3(body.surface);
  if (tets == 0 || !(volume > 0)) return;
  const double edge_m = base_edge_m(scene, volume),
               times = tets / expected_tets(volume, area_m2(body.surface), edge_m);
  const bool is_given = scene.body.tetmesh.has_value();
  // A press on 50,000 tets takes 2 GB.
  if (tets <= 50000 && (is_given || times <= kManyTimes)) return;
  const std::string cost =
      fmt::format("a press on it takes some {:.2g} GB of memory", memory_GB(tets));
  if (is_given)
    warnings.push_back(
        fmt::format("[body]: the tetmesh has {:.0f} tets; {}. Give a coarser one, or the surface "
                    "alone: a press refines the mesh where it is needed.",
                    tets, cost));
  else if (times > kManyTimes)
    warnings.push_back(
        fmt::format("[body]: the base mesh has {:.0f} tets, {:.0f} times what an edge of {:.3g} mm "
                    "needs; {}. No coarser surface of the body is sound, as where parts touch, "
                    "nearly touch or fold: take them apart or join them in a mesh editor, smooth "
                    "or simplify the surface, or set mesh_size.",
                    tets, times, 1e3 * edge_m, cost));
  else
    warnings.push_back(
        fmt::format("[body]: the base mesh has {:.0f} tets; {}. Make mesh_size larger than {:.3g} "
                    "mm, or leave it out: a press refines the mesh where it is needed.",
                    tets, cost, 1e3 * edge_m));
}

// Painted corners of tets; a node that several tets share comes several times.
std::vector<Vec3> painted_corners(const PaintedPart& part) {
  std::vector<Vec3> painted;
  for (Eigen::Index i = 0; i < part.volume().tets.size(); ++i)
    if (part.is_painted()[i / 4])
      painted.push_back(part.volume().nodes.row(part.volume().tets(i / 4, i % 4)));
  return painted;
}

// Nodes that lie where one before them does. They are sorted along a direction in which the nodes
// of a grid differ.
Eigen::Index coincident_nodes(const Points& nodes) {
  const double tolerance_m = 1e-9 * extent_m(nodes).norm();  // roundoff of nine digits
  const Eigen::VectorXd along = nodes * Vec3(0.61, 0.53, 0.59).normalized();
  std::vector<Eigen::Index> order(nodes.rows());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](Eigen::Index n) { return along[n]; });
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i; j-- > 0 && along[order[i]] - along[order[j]] <= tolerance_m;)
      if ((nodes.row(order[i]) - nodes.row(order[j])).norm() <= tolerance_m) {
        ++count;
        break;
      }
  return count;
}

Box bounds_of(const Region& region, const Points& vertices) {
  Box box{vertices.colwise().minCoeff(), vertices.colwise().maxCoeff()};
  if (const auto* ball = std::get_if<Ball>(&region))
    return {ball->center_m.array() - ball->radius_m, ball->center_m.array() + ball->radius_m};
  if (const auto* cuboid = std::get_if<Box>(&region)) return *cuboid;
  if (const auto* solid = std::get_if<Solid>(&region)) {
    const Points& corners = solid->boundary->surface.vertices;
    return {corners.colwise().minCoeff(), corners.colwise().maxCoeff()};
  }
  if (std::holds_alternative<Layer>(region)) return box;
  if (const auto* marked = std::get_if<Marked>(&region)) {
    const std::vector<Vec3> corners = painted_corners(*marked->part);
    if (corners.empty()) return box;  // of a mark on the surface, that of the body
    box = {corners.front(), corners.front()};
    for (const Vec3& at : corners) box = {box.low_m.cwiseMin(at), box.high_m.cwiseMax(at)};
    return box;
  }
  const auto* half = std::get_if<HalfSpace>(&region);
  (half->is_below ? box.high_m : box.low_m)[half->axis] = half->at_m;
  return box;
}

InclusionPlace place_of(const Region& region, const Body& body, const BoxTree& boxes) {
  const Box box = bounds_of(region, body.surface.vertices);
  const Vec3 cell = (box.high_m - box.low_m) / kSamplesAcross;
  InclusionPlace place;
  place.depth_m = std::numeric_limits<double>::infinity();
  int in_region = 0, in_body = 0;
  for (int i = 0; i < kSamplesAcross; ++i)
    for (int j = 0; j < kSamplesAcross; ++j)
      for (int k = 0; k < kSamplesAcross; ++k) {
        const Vec3 at = box.low_m + cell.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
        if (!contains(region, at)) continue;
        ++in_region;
        if (!is_inside(body.surface, boxes, at)) continue;
        ++in_body;
        const auto near = closest_point(body.surface, boxes, at, place.depth_m);
        if (near) place.depth_m = near->distance_m;
      }
  place.volume_m3 = in_body * cell.prod();
  const bool is_bounded = std::holds_alternative<Ball>(region) ||
                          std::holds_alternative<Box>(region) ||
                          std::holds_alternative<Solid>(region);
  place.inside = is_bounded ? static_cast<double>(in_body) / std::max(in_region, 1)
                            : std::numeric_limits<double>::quiet_NaN();
  if (const auto* ball = std::get_if<Ball>(&region))
    if (const auto near = closest_point(body.surface, boxes, ball->center_m))
      place.depth_m = near->distance_m - ball->radius_m;
  if (const auto* marked = std::get_if<Marked>(&region))  // which ends at the body's surface
    for (const Vec3& at : painted_corners(*marked->part))
      if (const auto near = closest_point(body.surface, boxes, at, place.depth_m))
        place.depth_m = near->distance_m;
  // Corners of a mesh are off by the rounding of float32, 1e-7 of the body's extent; 1e-3 would be
  // 0.1 mm of an organ.
  if (place.inside < kWhole || std::holds_alternative<HalfSpace>(region) ||
      place.depth_m < 1e-6 * extent_m(body.surface.vertices).maxCoeff())
    place.depth_m = 0;
  for (Eigen::Index t = 0; t < body.volume.tets.rows(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (int k = 0; k < 4; ++k) centre += body.volume.nodes.row(body.volume.tets(t, k)) / 4;
    place.tets += contains(region, centre);
  }
  return place;
}

}  // namespace

std::vector<std::string> doubts_of_shape(const Scene& scene, const Body& body) {
  std::vector<std::string> doubts;
  const Vec3 extent = extent_m(body.surface.vertices);
  // An organ in metres that is read as one in millimetres has 0.6 mm at most; a person has 2 m.
  if (extent.maxCoeff() < 1e-3 || extent.maxCoeff() > 5)
    doubts.push_back(
        fmt::format("[body]: it measures {}. Is length_unit right?", size_in_words(extent, 0)));
  if (const Eigen::Index doubled = scene.body.tetmesh ? coincident_nodes(body.volume.nodes) : 0) {
    doubts.push_back(fmt::format(
        "[body]: {} nodes of the tetmesh coincide with others, so the body is cut there and its "
        "sides move apart. If it is one body, merge them (Gmsh: Coherence, or Coherence Mesh).",
        doubled));
    return doubts;
  }
  std::vector<Surface> parts = parts_of(body.surface);
  std::erase_if(parts, [](const Surface& part) { return volume_m3(part) <= 0; });  // cavities
  if (parts.size() < 2) return doubts;
  std::ranges::stable_sort(parts, std::greater{}, volume_m3);
  const BoxTree boxes = triangle_boxes(parts[0]);
  std::string others;
  for (std::size_t p = 1; p < std::min(parts.size(), kListedParts); ++p) {
    double distance_m = std::numeric_limits<double>::infinity();
    for (const auto& vertex : parts[p].vertices.rowwise())
      if (const auto near = closest_point(parts[0], boxes, vertex, distance_m))
        distance_m = near->distance_m;
    others += fmt::format(", {} at a distance of {:.3g} mm",
                          size_in_words(extent_m(parts[p].vertices), 0), 1e3 * distance_m);
  }
  if (parts.size() > kListedParts)
    others += fmt::format(", and {} more", parts.size() - kListedParts);
  doubts.push_back(
      fmt::format("[body]: it is {} separate parts: {}{}. That is fine if it is meant; else join "
                  "them, or delete the others, in a mesh editor.",
                  parts.size(), size_in_words(extent_m(parts[0].vertices), 0), others));
  return doubts;
}

std::vector<std::string> implausible(const Scene& scene, const Body& body) {
  Warnings warnings;
  if (scene.material) check_material(*scene.material, "[material]", warnings);
  for (std::size_t i = 0; i < scene.inclusions.size(); ++i)
    check_material(scene.inclusions[i].material, "material of " + name_of_part(scene, i), warnings);
  check_mesh_size(scene, body, warnings);
  const Vec3 extent = extent_m(body.surface.vertices);
  const double size_m = extent.maxCoeff();
  for (const std::string& doubt : doubts_of_shape(scene, body)) warnings.push_back(doubt);
  const double thickness_m = extent.minCoeff(), depth_m = scene.experiments.each.depth_m;
  if (depth_m > 0.5 * thickness_m)
    warnings.push_back(
        fmt::format("[experiments]: a depth of {:.3g} mm goes through most of a body whose "
                    "smallest extent is {:.3g} mm. Is its unit right?",
                    1e3 * depth_m, 1e3 * thickness_m));
  if (scene.body.noise_m.value_or(0) > 0.1 * thickness_m)
    warnings.push_back(
        fmt::format("[body]: noise of {:.3g} mm on a body of {:.3g} mm takes its shape away. Is "
                    "its unit right?",
                    1e3 * *scene.body.noise_m, 1e3 * thickness_m));
  // Dry steel on skin has 0.6, on wet tissue 0.02 to 0.3.
  if (scene.probe.spec.friction > 1.5)
    warnings.push_back(fmt::format(
        "[probe]: a friction of {:.3g} is more than any tool has on tissue; 0.02 to 0.6 is usual.",
        scene.probe.spec.friction));
  const double tip_m = scene.probe.rigid->length_m;
  if (tip_m < 1e-3 * size_m)
    warnings.push_back(fmt::format(
        "[probe]: a tip radius of {:.3g} mm presses on a body of {:.3g} mm. Is its unit right?",
        1e3 * tip_m, 1e3 * size_m));
  return warnings;
}

std::vector<InclusionPlace> place_inclusions(const Scene& scene, const Body& body) {
  const BoxTree boxes = triangle_boxes(body.surface);
  std::vector<InclusionPlace> places;
  for (const InclusionSection& part : parts_of_body(scene, body)) {
    places.push_back(place_of(part.region, body, boxes));
    if (places.back().volume_m3 > 0) continue;
    throw Error(scene.path.string() + ": " + name_of_part(scene, places.size() - 1),
                "none of it is inside the body",
                fmt::format("Move it: the body spans {}.", span_in_words(body.surface.vertices)));
  }
  return places;
}

std::string size_in_words(const Vec3& extent_m, double volume_m3) {
  const double largest = extent_m.maxCoeff();
  const auto [scale, unit, cubic, cubic_unit] =
      largest >= 0.9995 ? std::tuple{1.0, "m", 1.0, "m3"}
      : largest >= 1e-3
          ? std::tuple{1e3, "mm", volume_m3 < 1e-4 ? 1e6 : 1e3, volume_m3 < 1e-4 ? "ml" : "l"}
          : std::tuple{1e6, "um", 1e18, "um3"};
  const Vec3 e = scale * extent_m;
  std::string words = fmt::format("{:.3g} x {:.3g} x {:.3g} {}", e[0], e[1], e[2], unit);
  if (volume_m3 > 0) words += fmt::format(", {:.3g} {}", cubic * volume_m3, cubic_unit);
  return words;
}

std::string in_mm(const Vec3& place_m) {
  const Vec3 mm = 1e3 * place_m;
  return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", mm[0], mm[1], mm[2]);
}

std::string span_in_words(const Points& nodes) {
  const Vec3 low = 1e3 * nodes.colwise().minCoeff(), high = 1e3 * nodes.colwise().maxCoeff();
  return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f}, z {:.1f} to {:.1f} mm", low[0],
                     high[0], low[1], high[1], low[2], high[2]);
}

void say_plausibility(const Scene& scene, const Body& body) {
  const std::vector<InclusionPlace> places = place_inclusions(scene, body);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const InclusionPlace& place = places[i];
    const std::string name = name_of_part(scene, i);
    if (const auto* layer = std::get_if<Layer>(&scene.inclusions[i].region)) {
      const double share = place.volume_m3 / volume_m3(body.surface);
      say("  {}: to a depth of {:.3g} mm, which is {:.0f} % of the body", name,
          1e3 * layer->depth_m(), 100 * share);
      if (share >= kWhole)
        warn("{}: the layers are as thick as the body, so nothing is left of [material]", name);
      continue;
    }
    say("  {}: {:.3g} ml, {}; {} tets of the base mesh, refined at the probe", name,
        1e6 * place.volume_m3,
        place.depth_m > 0 ? fmt::format("{:.1f} mm under the surface", 1e3 * place.depth_m)
                          : "reaches the surface",
        place.tets);
    if (place.inside < kWhole)
      warn("{}: {:.0f} % of it lies outside the body", name, 100 * (1 - place.inside));
  }
  for (const std::string& warning : implausible(scene, body)) warn("{}", warning);
}

}  // namespace palpate::tools
