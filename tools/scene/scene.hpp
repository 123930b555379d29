#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/materials/materials.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "tools/scene/region.hpp"

namespace palpate::tools {

/// First stage that a setting changes: the one whose fingerprint it belongs to. Later stages see it
/// through the files before them. none: it changes no result.
enum class Stage { prepare, simulate, surface, place, fit, validate, none };

// A scene.toml with its defaults filled in, SI throughout (docs/formats/scene.md has every key).

/// [probe] of a scene: numbers and directions as libfem wants them, the mesh still a file. The
/// shape "point" is for measured data alone: it has no keys, and simulation refuses it.
struct ProbeSection {
  ProbeSpec spec = sphere_spec(kDefaultBallRadius_m, kDefaultFriction);
  std::optional<std::filesystem::path> mesh;  ///< absolute; none once it is read into spec.mesh
  double mesh_unit_m = 0;
  std::optional<fem::Probe> rigid;  ///< the shape that `spec` describes (resolve_probes)
};

/// A rigid tool beside [probe]: [tool], [[experiments.probe]] or [[validate.tool]] of a scene. The
/// engine plays it as balls (docs/method-tools.md, section 29; at most one of row and balls_m), or
/// without any by the round end that it has along its press (section 30).
struct ToolSection {
  std::string name;
  ProbeSection probe;            ///< its shape; friction is that of [probe]
  int row = 0;                   ///< balls evenly along a capsule, from end to end
  Points balls_m;                ///< centres in the tool's own axes
  std::vector<double> radius_m;  ///< of each ball, or of all; none: the probe's, or the capsule's
  double tilt_rad = 0.6;         ///< up to which it leans in experiments, played as balls
  int paths = 0;                 ///< experiments that identify, of [tool] and [[experiments.probe]]
  int held_out = 0;              ///< that the statement compares, of [tool] and [[validate.tool]]

  bool has_balls() const { return row > 0 || balls_m.rows() > 0; }
};

/// An [[inclusion]] is read so, and a [[layer]].
struct InclusionSection {
  Region region;
  fem::MaterialParameters material;
};

/// A layer between a part of the body's boundary and what does not give.
struct BedSection {
  Region region;
  fem::MaterialParameters material;
  double thickness_m = 0.01;
  bool slides = false;  ///< frictionless: it resists along the boundary's normal alone
};

struct BodySection {
  std::optional<std::filesystem::path> surface;  ///< exactly one of the two, absolute
  std::optional<std::filesystem::path> tetmesh;
  double length_unit_m = 0;
  std::vector<Region> fixed;
  std::optional<double> mesh_size_m;  ///< edge of the base volume far from the probe
  std::optional<double> noise_m;      ///< of the surface's vertices, filtered; absent: kept
  std::optional<double> wrap_m;       ///< alpha of the repair of last resort; off when absent
  std::optional<double> wall_m;       ///< of a hollow body whose outer surface is `surface`
  std::optional<std::filesystem::path> cavity;  ///< its inner surface; at most one of both
  double pressure_Pa = 0;                       ///< in the lumens, in the body's own shape
};

/// test_points = "auto": points are added where prediction fails (docs/method.md, section 7).
struct PlacementSection {
  double tolerance = 0.07;  ///< relative force error at new points, p95; 0: spend the budget
  int budget = 200;         ///< most points simulated
};
inline constexpr int kFirstPoints = 12;  ///< where it starts: some four across a window

struct ExperimentsSection {
  std::optional<int> test_points = 40;        ///< absent: every vertex, or the file below
  std::optional<PlacementSection> placement;  ///< with test_points = kFirstPoints
  std::optional<std::filesystem::path> points_file;
  std::optional<Region> region;  ///< where a tool presses; of a ball the patch at its centre
  Experiments each;              ///< made at every test point
  double force_tolerance = 0;    ///< force error asked of a simulated row, relative; 0: as it comes
  bool surface = true;           ///< keep how the whole surface moves, so that the asset deforms
  int cycles = 4;                ///< of a body that softens: test points pressed in and out
  int pairs = 0;         ///< of two tools pressed side by side, which tell how they feel each other
  double memory_GB = 2;  ///< most that the factor of one experiment's mesh may take
};

struct FitSection {
  std::string family{name_of(CurveFamily::rings)};
  int degree = FitOptions{}.degree;
  int pieces = 0;  ///< 0: by evidence
  double tolerance = FitOptions{}.tolerance;
};

struct ValidateSection {
  int points = 12;  ///< held-out contact points
  int seed = 1;
  bool causes = true;          ///< press at held-out points, too, to split the error by cause
  double force_tolerance = 0;  ///< force error asked of held-out rows; 0: as of any other row
  /// Of a body that relaxes: the paths take these speeds by turns, and end with a hold.
  std::vector<double> speeds_m_s{0.001, 0.010, 0.100};
  double hold_s = 2;
  double tilt_rad = 0;    ///< up to which the tool leans on paths of that kind; 0: on none
  int pairs = 0;          ///< held-out paths of two tools
  double handle_m = 0.1;  ///< from a tool's point to its grip, about which torques are stated
  /// Standard deviations of what [material] and [probe] have, of Young's modulus and friction over
  /// the value: the statement's interval.
  double young_deviation = 0, poisson_deviation = 0, friction_deviation = 0;

  /// Held-out points that are pressed for `causes`: every second one, so paths of all kinds, but
  /// six at most: one costs as much as a held-out path.
  int presses() const { return causes ? std::min((points + 1) / 2, 6) : 0; }
};

struct Scene {
  std::filesystem::path path;  ///< of the file it comes from, for errors
  BodySection body;
  std::optional<fem::MaterialParameters>
      material;  ///< complete values; absent only for surfaces of measured data
  std::vector<InclusionSection> inclusions;  ///< layers first, the deepest before those above it
  std::vector<BedSection> beds;
  ProbeSection probe;
  std::optional<ToolSection> tool;
  std::vector<ToolSection> pressed;  ///< [[experiments.probe]]
  std::vector<ToolSection> stated;   ///< [[validate.tool]]
  ExperimentsSection experiments;
  FitSection fit;
  ValidateSection validate;
};

/// Makes the rigid shapes of [probe] and of all tools: parse_scene() those without a mesh,
/// open_scene() the others. A "point" has none. Throws Error at the section where a shape cannot be
/// made.
void resolve_probes(Scene& scene);
/// "[[layer]] 1" or "[[inclusion]] 1" of scene.inclusions.
std::string name_of_part(const Scene& scene, std::size_t i);

/// The rigid shape of [probe]. Throws Error where it has none.
const fem::Probe& rigid_probe(const Scene& scene);

/// "FILE: [probe]" and "FILE: tool `NAME`", where errors of them are.
std::string probe_place(const Scene& scene);
std::string tool_place(const Scene& scene, const ToolSection& tool);

/// Reads [tool]. Throws as read_probe.
ToolSection read_tool(SceneTable& table, const std::filesystem::path& folder, double friction);

/// Reads [[experiments.probe]] or [[validate.tool]]: tools that are pressed at some points, or that
/// the statement compares. points: their number where a table says nothing, and what it is of.
/// Throws as read_probe.
std::vector<ToolSection> read_tools(SceneTable& section, std::string_view key,
                                    const std::filesystem::path& folder, double friction,
                                    int points, int ToolSection::*of_which);

/// Reads the keys that the named shape takes. Throws Error for keys of other shapes, saying whose
/// they are, and as SceneTable does. Relative file names start at `folder`.
ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder);

/// The material of a table: `law`, and the keys of that law's parameter rows. Returns a value for
/// every row, SI; NaN for an optional one left out. may_relax: the keys
/// `relaxation` and `softening` are among them.
/// Throws Error with file:line:column for an unknown law or key (naming the nearest), a key missing
/// or of the wrong kind or unit, two keys that exclude each other, and values that the law refuses.
fem::MaterialParameters read_material(SceneTable table, bool may_relax = false);

/// A section that a manifest has, too. Throws Error at what is wrong in the file `path`.
FitSection read_fit(SceneTable table, const std::filesystem::path& path);

/// Makes a scene answer within minutes: five rows a press and a drag, six held-out paths, no split
/// of the error; 80 test points where they place themselves and few are dragged, else 12 with one
/// drag at the deepest of its depths.
void make_quick(Scene& scene);

/// Throws Error with file:line:column for unreadable TOML, unknown keys (naming the nearest known
/// one), wrong types and units, and values out of their range.
Scene read_scene(const std::filesystem::path& path);

/// The same from text; `path` names it in errors and anchors relative file names. With `errors`,
/// each section's first error goes there instead, and such a section keeps its defaults.
Scene parse_scene(const std::string& text, const std::filesystem::path& path,
                  std::vector<Error>* errors = nullptr);

/// Calls of_region for each region of a scene and of_probe for each rigid shape beside [probe] that
/// stages after `prepare` need, always in one order.
template <class SomeScene, class OfRegion, class OfProbe>
void visit_shapes(SomeScene& scene, const OfRegion& of_region, const OfProbe& of_probe) {
  for (auto& region : scene.body.fixed) of_region(region);
  for (auto& inclusion : scene.inclusions) of_region(inclusion.region);
  for (auto& bed : scene.beds) of_region(bed.region);
  if (auto& region = scene.experiments.region) of_region(*region);
  if (scene.tool) of_probe(scene.tool->probe);
  for (auto& tool : scene.pressed) of_probe(tool.probe);
}

}  // namespace palpate::tools
