#include "tools/stages/body/open_scene.hpp"

#include <fmt/core.h>

#include <memory>
#include <utility>

#include "libfem/mesh/read/frame.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "tools/console.hpp"
#include "tools/scene/scene_shapes.hpp"
#include "tools/stages/body/misread.hpp"

namespace palpate::tools {
namespace {

// A remedy for a surface that cannot be wrapped, as a body can.
std::string without_wrap(std::string remedy) {
  constexpr std::string_view kOffer = ", or wrap it.";
  if (remedy.ends_with(kOffer)) remedy.replace(remedy.size() - kOffer.size(), kOffer.size(), ".");
  return remedy;
}

// Turns a surface of one anatomical frame into the frame of the body's file: LPS and RAS differ by
// half a turn about z.
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

// Reads what a region is made of from the file that has it.
void read_region_file(Region& region, const BodySection& body) {
  const double length_unit_m = body.length_unit_m;
  if (auto* marked = std::get_if<Marked>(&region))
    marked->part = std::make_shared<const PaintedPart>(
        read_marked_part(body.tetmesh ? *body.tetmesh : *body.surface, length_unit_m,
                         body.tetmesh.has_value(), marked->mark));
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
  for (const InclusionSection& inclusion : scene.inclusions)
    if (const auto* marked = std::get_if<Marked>(&inclusion.region);
        marked != nullptr && marked->part->is_on_faces())
      throw Error(scene.path.string() + ": [[inclusion]]",
                  fmt::format("\"{}\" marks faces, which fill nothing", marked->mark.name),
                  "Mark tetrahedra of a tetmesh, or give a closed surface with inside.");
  return scene;
}

std::string body_place(const Scene& scene) { return scene.path.string() + ": [body]"; }

void check_simulated(const Scene& scene) {
  const std::string file = scene.path.string();
  if (!scene.material)
    throw Error(file, "the scene has no [material]",
                "Add [material] with law and its parameters, such as young and poisson.");
  fem::make_probe(scene.probe.spec, file + ": [probe]");
}

}  // namespace palpate::tools
