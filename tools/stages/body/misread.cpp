#include "tools/stages/body/misread.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/misread_unit.hpp"
#include "tools/stages/body/plausibility.hpp"

namespace palpate::tools {
namespace {

constexpr double kLong_m = 0.3;

// A length of the scene, or places of one of its regions, and the key that has it.
struct NamedLength {
  std::string key;
  double value_m = 0;
};
struct NamedPlaces {
  std::string key;
  Points places_m;
};

struct SceneLengths {
  std::vector<NamedLength> lengths;
  std::vector<NamedPlaces> places;

  void add(const std::string& key, double value_m) { lengths.push_back({key, value_m}); }
  void add(const std::string& key, const Vec3& place_m) {
    places.push_back({key, Points(place_m.transpose())});
  }
  void add(const std::string& key, const Region& region) {
    if (const auto* ball = std::get_if<Ball>(&region)) {
      add(key + ", center", ball->center_m);
      add(key + ", radius", ball->radius_m);
    }
    if (const auto* box = std::get_if<Box>(&region)) {
      Points corners(2, 3);
      corners << box->low_m.transpose(), box->high_m.transpose();
      places.push_back({key + ", box", corners});
    }
  }
  bool is_any_long() const {
    return std::ranges::any_of(lengths,
                               [](const NamedLength& l) { return l.value_m >= kLong_m; }) ||
           std::ranges::any_of(places, [](const NamedPlaces& p) {
             return p.places_m.cwiseAbs().maxCoeff() >= kLong_m;
           });
  }
};

SceneLengths lengths_of(const Scene& scene) {
  SceneLengths out;
  for (const auto& [key, values] : scene.probe.spec.values)
    if (probe_dimension(key) == Dimension::length)
      for (const double value : values) out.add("[probe] " + key, value);
  if (scene.body.mesh_size_m) out.add("[body] mesh_size", *scene.body.mesh_size_m);
  const Experiments& each = scene.experiments.each;
  out.add("[experiments] depth", each.depth_m);
  if (!each.drag_depths_m.empty()) out.add("[experiments] drag_distance", each.drag_distance_m);
  if (scene.experiments.region) {
    const std::string key = "[experiments] region";
    if (scene.experiments.region->part) out.add(key, *scene.experiments.region->part);
  }
  for (const Region& region : scene.body.fixed) out.add("[body] fixed", region);
  for (const InclusionSection& inclusion : scene.inclusions)
    out.add("[[inclusion]]", inclusion.region);
  return out;
}

Surface surface_of(const BodySection& body) {
  if (!body.tetmesh) return read_surface(*body.surface, body.length_unit_m);
  const TetMesh volume = read_tet_mesh(*body.tetmesh, body.length_unit_m);
  return {volume.nodes, fem::boundary_triangles(volume.tets)};
}

// A box that spans the body says "all of it", however large it is.
bool spans(const Points& corners, const Points& body_m) {
  return corners.rows() == 2 &&
         (corners.row(0).array() <= body_m.colwise().minCoeff().array()).all() &&
         (corners.row(1).array() >= body_m.colwise().maxCoeff().array()).all();
}

[[noreturn]] void refuse(const Scene& scene, const std::string& key, const std::string& is,
                         const Vec3& extent, const std::string& example) {
  throw Error(
      fmt::format("{}: {}", scene.path.string(), key),
      fmt::format("{}, and the body measures {}", is, size_in_words(extent, 0)),
      fmt::format("Numbers without a unit are metres: write {} if that is meant.", example));
}

}  // namespace

void refuse_misread_lengths(const Scene& scene) {
  const SceneLengths all = lengths_of(scene);
  if (!all.is_any_long()) return;
  const Surface body = surface_of(scene.body);
  const Vec3 extent = extent_m(body.vertices);
  for (const NamedLength& length : all.lengths)
    if (const auto unit = misread_unit(length.value_m, extent))
      refuse(scene, length.key, fmt::format("is {:.4g} m", length.value_m), extent,
             fmt::format("\"{:.4g} {}\"", length.value_m, *unit));
  for (const NamedPlaces& part : all.places)
    if (const auto unit = misread_unit(part.places_m, body);
        unit && !spans(part.places_m, body.vertices)) {
      const auto at = part.places_m.row(0);
      refuse(scene, part.key, fmt::format("is at ({:.4g}, {:.4g}, {:.4g}) m", at[0], at[1], at[2]),
             extent, fmt::format("[\"{:.4g} {}\", ...]", at[0], *unit));
    }
}

}  // namespace palpate::tools
