#include "tools/stages/body/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "tools/console.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {
namespace {

// A length of the scene, or places of one of its regions, and the key that has it.
struct SceneLength {
  std::string key;
  double value_m = 0;
  Points places_m{0, 3};
};

void add_region(const std::string& key, const Region& region, std::vector<SceneLength>& out) {
  if (const auto* ball = std::get_if<Ball>(&region)) {
    out.push_back({key + ", center", 0, Points(ball->center_m.transpose())});
    out.push_back({key + ", radius", ball->radius_m});
  }
  if (const auto* box = std::get_if<Box>(&region)) {
    Points corners(2, 3);
    corners << box->low_m.transpose(), box->high_m.transpose();
    out.push_back({key + ", box", 0, corners});
  }
  if (const auto* layer = std::get_if<Layer>(&region))
    out.push_back({"[[layer]] thickness", layer->thickness_m});
}

std::vector<SceneLength> lengths_of(const Scene& scene) {
  std::vector<SceneLength> out;
  for (const auto& [key, values] : scene.probe.spec.values)
    if (probe_dimension(key) == Dimension::length)
      for (const double value : values) out.push_back({"[probe] " + key, value});
  if (scene.body.mesh_size_m) out.push_back({"[body] mesh_size", *scene.body.mesh_size_m});
  const Experiments& each = scene.experiments.each;
  out.push_back({"[experiments] depth", each.depth_m});
  if (!each.drag_depths_m.empty())
    out.push_back({"[experiments] drag_distance", each.drag_distance_m});
  if (const auto& region = scene.experiments.region)
    add_region("[experiments] region", *region, out);
  for (const Region& region : scene.body.fixed) add_region("[body] fixed", region, out);
  for (const InclusionSection& inclusion : scene.inclusions)
    add_region("[[inclusion]]", inclusion.region, out);
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

// Refuses numbers that were meant in another unit: a bare `radius = 8` is 8 m. Throws Error,
// naming key, size of the body and likely unit, where a length of probe, experiments or a region
// is ten times the body or more, or a region lies beside the body, and in mm, cm or um would not.
// Reads the body's mesh only where a length of the scene is long for any body (0.3 m).
void refuse_misread_lengths(const Scene& scene) {
  const std::vector<SceneLength> all = lengths_of(scene);
  if (std::ranges::none_of(all, [](const SceneLength& length) {
        return length.value_m >= 0.3 || (length.places_m.array().abs() >= 0.3).any();
      }))
    return;
  const Surface body = surface_of(scene.body);
  const Vec3 extent = extent_m(body.vertices);
  for (const SceneLength& length : all)
    if (const auto unit = misread_unit(length.value_m, extent))
      refuse(scene, length.key, fmt::format("is {:.4g} m", length.value_m), extent,
             fmt::format("\"{:.4g} {}\"", length.value_m, *unit));
  for (const SceneLength& part : all)
    if (const auto unit =
            part.places_m.rows() > 0 ? misread_unit(part.places_m, body) : std::nullopt;
        unit && !spans(part.places_m, body.vertices)) {
      const auto at = part.places_m.row(0);
      refuse(scene, part.key, fmt::format("is at ({:.4g}, {:.4g}, {:.4g}) m", at[0], at[1], at[2]),
             extent, fmt::format("[\"{:.4g} {}\", ...]", at[0], *unit));
    }
}

// A remedy for a surface that cannot be wrapped, as a body can.
std::string without_wrap(std::string remedy) {
  constexpr std::string_view kOffer = ", or wrap it.";
  if (remedy.ends_with(kOffer)) remedy.replace(remedy.size() - kOffer.size(), kOffer.size(), ".");
  return remedy;
}

// Reads what a region is made of from the file that has it.
void read_region_file(Region& region, const BodySection& body) {
  const double length_unit_m = body.length_unit_m;
  if (auto* marked = std::get_if<Marked>(&region))
    marked->part = std::make_shared<const PaintedPart>(
        read_group(body.tetmesh ? *body.tetmesh : *body.surface, length_unit_m,
                   body.tetmesh.has_value(), marked->group));
  auto* solid = std::get_if<Solid>(&region);
  if (solid == nullptr) return;
  const std::string file = solid->file.string();
  Mended mended;
  try {
    Surface surface = read_surface(solid->file, length_unit_m);
    turn_into_frame_of_body(body.tetmesh ? *body.tetmesh : *body.surface, solid->file, surface);
    mended = mend_surface(std::move(surface), {}, file);
  } catch (const Error& e) {
    throw Error(e.where(), e.fact(), without_wrap(e.remedy()));
  }
  for (const std::string& change : mended.changes) say("  mended: {}: {}", file, change);
  solid->boundary = std::make_shared<const Enclosed>(std::move(mended.surface));
}

}  // namespace

// LPS and RAS differ by half a turn about z.
void turn_into_frame_of_body(const std::filesystem::path& body, const std::filesystem::path& file,
                             Surface& surface) {
  const std::string bodys = stated_frame(body), own = stated_frame(file);
  if (own == bodys) return;
  const auto name = body.filename().string();
  if (own.empty() || bodys.empty()) {
    warn("{}: states {}, and {} states {}: it is taken to be in the same frame", file.string(),
         own.empty() ? "no frame" : own, name, bodys.empty() ? "none" : bodys);
    return;
  }
  const auto is_known = [](const std::string& frame) { return frame == "LPS" || frame == "RAS"; };
  if (!is_known(own) || !is_known(bodys))
    throw Error(file.string(), fmt::format("states the frame {}, and {} {}", own, name, bodys),
                "Export both in one frame, LPS or RAS.");
  surface.vertices.leftCols<2>() *= -1;
  say("  frame: {} is in {}, and turned by half a turn about z into {}, the frame of {}",
      file.string(), own, bodys, name);
}

Scene open_scene(const std::filesystem::path& path) {
  Scene scene = read_scene(path);
  refuse_misread_lengths(scene);
  const auto read_mesh = [](ProbeSection& probe) {
    if (probe.mesh) probe.spec.mesh = read_surface(*probe.mesh, probe.mesh_unit_m);
  };
  visit_shapes(
      scene, [&](Region& region) { read_region_file(region, scene.body); }, read_mesh);
  read_mesh(scene.probe);
  for (ToolSection& tool : scene.stated) read_mesh(tool.probe);
  resolve_probes(scene);
  for (const InclusionSection& inclusion : scene.inclusions)
    if (const auto* marked = std::get_if<Marked>(&inclusion.region);
        marked != nullptr && marked->part->is_on_faces())
      throw Error(scene.path.string() + ": [[inclusion]]",
                  fmt::format("\"{}\" marks faces, which fill nothing", marked->group),
                  "Mark tetrahedra of a tetmesh, or give a closed surface with inside.");
  return scene;
}

std::string body_place(const Scene& scene) { return scene.path.string() + ": [body]"; }

void check_simulated(const Scene& scene) {
  const std::string file = scene.path.string();
  if (!scene.material)
    throw Error(file, "the scene has no [material]",
                "Add [material] with law and its parameters, such as young and poisson.");
  if (!scene.probe.rigid) fem::find_shape(scene.probe.spec.shape, probe_place(scene));
}

}  // namespace palpate::tools
