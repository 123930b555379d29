#include "tools/scene/region.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

HalfSpace read_half_space(SceneTable table, bool is_below) {
  static const std::vector<std::string_view> kAxes{"x", "y", "z"};
  HalfSpace half;
  half.is_below = is_below;
  half.axis = table.choice("axis", "z", kAxes)[0] - 'x';
  half.at_m = table.required_quantity("at", Dimension::length, -kAnyLength, kAnyLength);
  table.finish();
  return half;
}

Ball read_ball(SceneTable table) {
  Ball ball;
  ball.center_m = table.point("center");
  ball.radius_m = table.required_quantity("radius", Dimension::length, kSmallestLength, kAnyLength);
  table.finish();
  return ball;
}

Box read_box(SceneTable& table) {
  const auto [low, high] = table.corners("box");
  if (!(low.array() < high.array()).all())
    throw Error(table.where("box"), "box of " + table.name() + " is empty",
                "Give the lower corner first: every coordinate of the second must be larger.");
  return {low, high};
}

constexpr std::string_view kRegions = "below, above, box, sphere, inside, group";

// The one region a table names; nothing when it names none.
std::optional<Region> find_region(SceneTable& table, const std::filesystem::path& scene) {
  std::optional<Region> region;
  int named = 0;
  const auto take = [&](const char* key, auto&& read) {
    if (!table.has(key)) return;
    ++named;
    region = read();
  };
  take("below", [&] { return read_half_space(table.table("below", "below"), true); });
  take("above", [&] { return read_half_space(table.table("above", "above"), false); });
  take("sphere", [&] { return read_ball(table.table("sphere", "sphere")); });
  take("box", [&] { return read_box(table); });
  take("inside", [&] { return Solid{file_beside(scene, table.text("inside", "")), {}}; });
  take("group", [&] { return Marked{table.text("group", ""), {}}; });
  if (named > 1)
    throw Error(table.where_table(), table.name() + " names more than one region",
                fmt::format("Keep one of {}.", kRegions));
  return region;
}

}  // namespace

Enclosed::Enclosed(Surface closed) : surface(std::move(closed)), boxes(triangle_boxes(surface)) {}

bool contains(const Region& region, const Vec3& point) {
  return std::visit(
      Overloaded{
          [&](const HalfSpace& r) {
            return r.is_below ? point[r.axis] <= r.at_m : point[r.axis] >= r.at_m;
          },
          [&](const Box& r) {
            return (point.array() >= r.low_m.array()).all() &&
                   (point.array() <= r.high_m.array()).all();
          },
          [&](const Ball& r) {
            return (point - r.center_m).squaredNorm() <= r.radius_m * r.radius_m;
          },
          [&](const Solid& r) { return is_inside(r.boundary->surface, r.boundary->boxes, point); },
          [&](const Marked& r) { return r.part->contains(point); },
          [&](const Layer& r) {
            bool is_in = false;
            double squared_m2 = r.depth_m() * r.depth_m();
            r.outer->boxes.visit_nearest(point, squared_m2, [&](std::int32_t f, double& most) {
              const auto [a, b, c] = corners_of(r.outer->surface, f);
              is_in = is_in || nearest_on_triangle(point, a, b, c).distance_m <= r.depth_m();
              if (is_in) most = -1;  // ends the search
            });
            return is_in;
          },
      },
      region);
}

std::optional<Vec3> center_of(const std::optional<Region>& region) {
  const Ball* ball = region ? std::get_if<Ball>(&*region) : nullptr;
  return ball != nullptr ? std::optional(ball->center_m) : std::nullopt;
}

bool any_contains(const std::vector<Region>& regions, const Vec3& point, bool is_on_boundary) {
  return std::any_of(regions.begin(), regions.end(), [&](const Region& region) {
    const auto* marked = std::get_if<Marked>(&region);
    return (is_on_boundary || marked == nullptr || !marked->part->is_on_faces()) &&
           contains(region, point);
  });
}

std::filesystem::path file_beside(const std::filesystem::path& scene, const std::string& name) {
  static constexpr std::string_view kData = "$PALPATE_DATA/";
  std::filesystem::path path(name);
  if (name.starts_with(kData)) {
    const char* folder = std::getenv("PALPATE_DATA");
    if (folder == nullptr)
      throw Error(
          scene.string(), fmt::format("\"{}\" needs PALPATE_DATA, which is not set", name),
          "Set it to the folder that holds the meshes; the scene says where they can be had.");
    path = std::filesystem::path(folder) / name.substr(kData.size());
  }
  return std::filesystem::absolute(path.is_absolute() ? path : scene.parent_path() / path)
      .lexically_normal();
}

Region take_region(SceneTable& table, const std::filesystem::path& scene) {
  const auto region = find_region(table, scene);
  if (!region)
    throw Error(table.where_table(), table.name() + " names no region",
                fmt::format("Give one of {}.", kRegions));
  return *region;
}

Region read_region(SceneTable table, const std::filesystem::path& scene) {
  Region region = take_region(table, scene);
  table.finish();
  return region;
}

}  // namespace palpate::tools
