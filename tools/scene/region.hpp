#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::tools {

class SceneTable;

/// A part of space named by a scene: what is held, what is reachable, what an inclusion fills.
struct HalfSpace {
  int axis = 2;
  double at_m = 0;
  bool is_below = true;
};
struct Box {
  Vec3 low_m = Vec3::Zero(), high_m = Vec3::Zero();
};
struct Ball {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};
/// A closed surface, outward, and the boxes to search it by.
struct Enclosed {
  explicit Enclosed(Surface closed);
  Surface surface;
  BoxTree boxes;
};
/// The inside of a closed surface, in the body's unit and frame. The scene names the file; who
/// opens a scene reads it.
struct Solid {
  std::filesystem::path file;
  std::shared_ptr<const Enclosed> boundary;
};
/// A group of the body's own mesh file. The scene names it; who opens a scene reads the file.
struct Marked {
  std::string group;
  std::shared_ptr<const PaintedPart> part;
};
/// A layer lies no deeper below the outer surface of the body than its thickness and that of the
/// layers above it; `outer` is known once there is a body (parts_of_body).
struct Layer {
  double thickness_m = 0, above_m = 0;
  std::shared_ptr<const Enclosed> outer;

  double depth_m() const { return above_m + thickness_m; }
};
using Region = std::variant<HalfSpace, Box, Ball, Solid, Marked, Layer>;

/// The centre of its ball; none of other parts.
std::optional<Vec3> center_of(const std::optional<Region>& region);

/// Sides of a body.
inline constexpr std::array<std::string_view, 6> kSides{"-z", "+z", "-x", "+x", "-y", "+y"};

/// Borders belong to the region, of a solid one side of them. What names a file has been read.
bool contains(const Region& region, const Vec3& point);

/// True if a place of the body lies in one of them; what is marked on faces has places of its
/// boundary only.
bool any_contains(const std::vector<Region>& regions, const Vec3& point, bool is_on_boundary);

/// The file that a scene names, absolute: beside the scene, or below the folder that PALPATE_DATA
/// names. Throws Error where the scene needs that folder and it is not set.
std::filesystem::path file_beside(const std::filesystem::path& scene, const std::string& name);

/// The one region that the keys of a table name; its other keys are left. Throws Error with
/// file:line:column where they name none or several, or one of its values is wrong.
Region take_region(SceneTable& table, const std::filesystem::path& scene);

/// The same of a table that holds nothing else.
Region read_region(SceneTable table, const std::filesystem::path& scene);

}  // namespace palpate::tools
