#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfem/materials/materials.hpp"
#include "tools/scene/probe.hpp"
#include "tools/scene/region.hpp"

namespace palpate::tools {

// A scene.toml with its defaults filled in, SI throughout (docs/formats.md has every key).

struct InclusionSection {
  Region region;
  fem::MaterialParameters material;
};

struct BodySection {
  std::optional<std::filesystem::path> surface;  ///< exactly one of the two, absolute
  std::optional<std::filesystem::path> tetmesh;
  double length_unit_m = 0;
  std::string element = "auto";
  std::vector<Region> fixed;
  std::optional<double> mesh_size_m;  ///< edge of the base volume far from the probe
  std::optional<double> wrap_m;       ///< alpha of the repair of last resort; off when absent
};

/// test_points = "auto": points are added where prediction fails (docs/method.md, section 7).
struct PlacementSection {
  double tolerance = 0.07;  ///< relative force error at new points, p95; 0: spend the budget
  int budget = 100;         ///< most points simulated
};
inline constexpr int kFirstPoints = 12;  ///< where it starts: some four across a window

struct ExperimentsSection {
  std::optional<int> test_points = 40;        ///< absent: every vertex, or the file below
  std::optional<PlacementSection> placement;  ///< with test_points = kFirstPoints
  std::optional<std::filesystem::path> points_file;
  std::optional<Region> region;
  double depth_m = 0.010;
  int press_steps = 10;
  std::vector<double> drag_depths_m;
  double drag_distance_m = 0.008;
  int drag_directions = 2;
  int drag_steps = 8;
  double force_tolerance = 0;  ///< force error asked of a simulated row, relative; 0: as it comes
};

struct FitSection {
  std::string family = "auto";
  int degree = 3;
  int pieces = 0;  ///< 0: by evidence
  double tolerance = 0.02;
  std::optional<double> smoothing{};  ///< over neighbouring points; none: "auto", 0: "none"
};

struct ExportSection {
  std::string precision = "float32";
  bool guard = true;
  std::string repair = "none";
};

struct ValidateSection {
  int points = 12;
  int seed = 1;
  bool causes = true;  ///< simulate at the held-out points, too, to split the error by cause
};

struct Scene {
  std::filesystem::path path;  ///< of the file
  std::string text;            ///< the file, verbatim
  BodySection body;
  std::optional<fem::MaterialParameters>
      material;  ///< complete values; absent only for surfaces of measured data
  std::vector<InclusionSection> inclusions;
  ProbeSection probe;
  ExperimentsSection experiments;
  FitSection fit;
  ExportSection export_;
  ValidateSection validate;
};

/// Throws Error with file:line:column for unreadable TOML, unknown keys (naming the nearest known
/// one), wrong types and units, and values out of their range.
Scene read_scene(const std::filesystem::path& path);

/// The same from text; `path` names it in errors and anchors relative file names.
Scene parse_scene(const std::string& text, const std::filesystem::path& path);

/// Canonical texts of what each stage reads from the scene. Two scenes with equal text give equal
/// results; comments, key order and spelling of units do not count.
std::string canonical_body(const Scene& scene);
std::string canonical_experiments(const Scene& scene);
/// canonical_experiments without what chooses the points: what the rows of one point come from.
std::string canonical_point(const Scene& scene);
std::string canonical_fit(const Scene& scene);
std::string canonical_export(const Scene& scene);
std::string canonical_validate(const Scene& scene);

}  // namespace palpate::tools
