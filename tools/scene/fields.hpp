#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "tools/scene/scene.hpp"

// The settings of a scene, each named once. `visit` hands every member of a section to a visitor
// with its key, the stage whose result it changes, and the values it may take. What reads scenes
// and what makes canonical texts are such visitors. A section is
// taken apart by structured binding, so a new member does not compile until it is named here.

namespace palpate::tools {

inline constexpr double kAnyLength = 1e6;                    // m; beyond it the unit is wrong
inline constexpr double kSmallestLength = 1e-9;              // m
inline constexpr int kMaxPoints = 10000;                     // as many as can be triangulated
inline constexpr double kMostTilt_rad = 1.3962634015954636;  // 80 degrees

/// Range of a value.
struct Length {};    ///< m
struct Speed {};     ///< m/s
struct Duration {};  ///< s
struct Pressure {};  ///< Pa
struct Tilt {};      ///< rad, from upright
struct Number {
  double low = 0, high = 1;
};
struct Whole {
  int low = 0, high = 1000;
};
struct Choice {
  std::vector<std::string_view> names;
};
struct Any {};         ///< whatever the type holds
struct File {};        ///< counts by its name; a fingerprint adds its content
struct MeshUnit {};    ///< metres in one unit of a mesh file
struct PointCount {};  ///< a number; other words fill `placement` and `points_file`

inline Choice family_choice() {
  Choice choice;
  for (const CurveFamilyName& row : kCurveFamilyNames) choice.names.push_back(row.name);
  return choice;
}

// Section: the struct or its const form.
template <class Section, class Plain>
concept SectionOf = std::same_as<std::remove_const_t<Section>, Plain>;

// A probe is read key by key of its shape (read_probe).
template <class Visitor>
void visit(SectionOf<ProbeSpec> auto& section, Visitor& f) {
  auto& [shape, values, mesh, orientation, friction] = section;
  f(Stage::simulate, "shape", shape, Choice{});
  f(Stage::simulate, "values", values, Any{});
  f(Stage::simulate, "mesh", mesh, Any{});
  f(Stage::simulate, "orientation", orientation, Any{});
  f(Stage::simulate, "friction", friction, Number{});
}

// But for its shape, which is read as a probe's, and what the statement alone compares.
template <class Visitor>
void visit(SectionOf<ToolSection> auto& section, Visitor& f) {
  auto& [name, probe, row, balls_m, radius_m, tilt_rad, paths, held_out] = section;
  f(Stage::fit, "name", name, Choice{});
  f(Stage::fit, "row", row, Whole{});
  f(Stage::fit, "balls", balls_m, Any{});
  f(Stage::fit, "radii", radius_m, Length{});
  f(Stage::fit, "tilt", tilt_rad, Tilt{});
  f(Stage::fit, "paths", paths, Whole{});
}

template <class Visitor>
void visit(SectionOf<BodySection> auto& section, Visitor& f) {
  auto& [surface, tetmesh, length_unit_m, fixed, mesh_size_m, noise_m, wrap_m, wall_m, cavity,
         pressure_Pa] = section;
  f(Stage::prepare, "surface", surface, File{});
  f(Stage::prepare, "tetmesh", tetmesh, File{});
  f(Stage::prepare, "length_unit", length_unit_m, MeshUnit{});
  f(Stage::prepare, "fixed", fixed, Any{});
  f(Stage::prepare, "mesh_size", mesh_size_m, Length{});
  f(Stage::prepare, "noise", noise_m, Length{});
  f(Stage::prepare, "wrap", wrap_m, Length{});
  f(Stage::prepare, "wall", wall_m, Length{});
  f(Stage::prepare, "cavity", cavity, File{});
  f(Stage::simulate, "pressure", pressure_Pa, Pressure{});
}

template <class Visitor>
void visit(SectionOf<std::optional<fem::MaterialParameters>> auto& material, Visitor& f) {
  f(Stage::simulate, "material", material, Any{});
}

template <class Visitor>
void visit(SectionOf<InclusionSection> auto& section, Visitor& f) {
  auto& [region, material] = section;
  f(Stage::simulate, "", region, Any{});
  f(Stage::simulate, "material", material, Any{});
}

template <class Visitor>
void visit(SectionOf<BedSection> auto& section, Visitor& f) {
  auto& [region, material, thickness_m, slides] = section;
  f(Stage::simulate, "", region, Any{});
  f(Stage::simulate, "material", material, Any{});
  f(Stage::simulate, "thickness", thickness_m, Length{});
  f(Stage::simulate, "slides", slides, Any{});
}

template <class Visitor>
void visit(SectionOf<PlacementSection> auto& section, Visitor& f) {
  auto& [tolerance, budget] = section;
  f(Stage::place, "tolerance", tolerance, Number{});
  f(Stage::place, "budget", budget, Whole{kFirstPoints, kMaxPoints});
}

template <class Visitor>
void visit(SectionOf<Experiments> auto& section, Visitor& f) {
  auto& [depth_m, press_steps, drag_depths_m, drag_distance_m, drag_directions, drag_steps] =
      section;
  f(Stage::simulate, "depth", depth_m, Length{});
  f(Stage::simulate, "press_steps", press_steps, Whole{1, 1000});
  f(Stage::simulate, "drag_depths", drag_depths_m, Length{});
  f(Stage::simulate, "drag_distance", drag_distance_m, Length{});
  f(Stage::simulate, "drag_directions", drag_directions, Whole{0, 360});
  f(Stage::simulate, "drag_steps", drag_steps, Whole{1, 1000});
}

template <class Visitor>
void visit(SectionOf<ExperimentsSection> auto& section, Visitor& f) {
  auto& [test_points, placement, points_file, region, each, force_tolerance, surface, cycles, pairs,
         memory_GB] = section;
  f(Stage::prepare, "test_points", test_points, PointCount{});
  f(Stage::place, "", placement, PointCount{});
  f(Stage::prepare, "points_file", points_file, PointCount{});
  f(Stage::prepare, "region", region, Any{});
  visit(each, f);
  f(Stage::simulate, "force_tolerance", force_tolerance, Number{});
  f(Stage::surface, "surface", surface, Any{});
  f(Stage::fit, "cycles", cycles, Whole{1, 1000});
  f(Stage::fit, "pairs", pairs, Whole{0, 1000});
  f(Stage::none, "memory_GB", memory_GB, Number{0.01, 1e4});
}

template <class Visitor>
void visit(SectionOf<FitSection> auto& section, Visitor& f) {
  auto& [family, degree, pieces, tolerance] = section;
  f(Stage::fit, "family", family, family_choice());
  f(Stage::fit, "degree", degree, Whole{1, 4});
  f(Stage::fit, "pieces", pieces, Whole{0, 256});
  f(Stage::fit, "tolerance", tolerance, Number{1e-6, 1});
}

template <class Visitor>
void visit(SectionOf<ValidateSection> auto& section, Visitor& f) {
  auto& [points, seed, causes, force_tolerance, speeds_m_s, hold_s, tilt_rad, pairs, handle_m,
         young_deviation, poisson_deviation, friction_deviation] = section;
  f(Stage::validate, "points", points, Whole{1, 100000});
  f(Stage::validate, "seed", seed, Whole{0, 1 << 30});
  f(Stage::validate, "causes", causes, Any{});
  f(Stage::validate, "force_tolerance", force_tolerance, Number{});
  f(Stage::validate, "speeds", speeds_m_s, Speed{});
  f(Stage::validate, "hold", hold_s, Duration{});
  f(Stage::validate, "tilt", tilt_rad, Tilt{});
  f(Stage::validate, "pairs", pairs, Whole{0, 1000});
  f(Stage::validate, "handle", handle_m, Length{});
  f(Stage::validate, "young_deviation", young_deviation, Number{0, 10});
  f(Stage::validate, "poisson_deviation", poisson_deviation, Number{0, 0.5});
  f(Stage::validate, "friction_deviation", friction_deviation, Number{0, 10});
}

}  // namespace palpate::tools
