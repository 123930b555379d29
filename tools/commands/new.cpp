#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfem/mesh/read/read.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/scene.hpp"
#include "tools/setup/propose.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

// The text of an OFF file in metres, to 1 fm: 1e-14 of an organ, and 1e-6 of the smallest body that
// is read. With all digits of a double, the division's roundoff can be below the 1.2e-38 that a
// reader takes.
std::string off_text(const Surface& surface) {
  std::string text = "OFF\n" + std::to_string(surface.vertices.rows()) + " " +
                     std::to_string(surface.triangles.rows()) + " 0\n";
  for (const auto& p : surface.vertices.rowwise())
    text += fmt::format("{:.15f} {:.15f} {:.15f}\n", p[0], p[1], p[2]);
  for (const auto& t : surface.triangles.rowwise())
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  return text;
}

class New final : public Command {
 public:
  explicit New(Arguments& arguments) {
    arguments.positional("mesh", mesh_,
                         "Surface mesh: OBJ, STL, PLY, OFF or VTK; or tetrahedra: Gmsh's MSH; with "
                         "--path the asset to play "
                         "on, asset.palp; with --recordings the folder of a rig's files");
    // Nothing is replaced: it may have been changed by hand.
    arguments.output("-o,--output", output_,
                     "Scene to write, scene.toml, or with --path PATH.csv; must not exist", {});
    arguments.option("--unit UNIT", choices_.unit,
                     "Length unit of the mesh, such as mm; without it the likely one");
    arguments.option("--tissue NAME", choices_.tissue,
                     "Material of the table in data/materials.toml, such as liver or breast-fat; "
                     "without it the one that the mesh's name means, or liver");
    arguments.option(
        "--held SIDE", choices_.held,
        "Side that the body rests on: -x, +x, -y, +y, -z or +z; without it the flattest");
    arguments.flag("--wrap", choices_.wrap,
                   "Wrap a mesh that cannot be mended, though that moves its surface by more than "
                   "2 % of its diagonal");
    arguments.flag("--path", is_path_,
                   "Write a path for `replay` instead: down on the middle of the asset's window, a "
                   "press, a slide, a lift");
    arguments.flag("--recordings", is_recordings_,
                   "Write a manifest instead: how the recordings in a folder are read");
  }

  int run(Reply& reply) override {
    if (is_recordings_ || is_path_) check_of_scene_alone();
    if (is_recordings_) return write_manifest(reply);
    if (is_path_) return write_path(reply);
    const Surface surface = read_body();
    const fs::path scene = fs::absolute(output_).lexically_normal(), folder = scene.parent_path();
    choices_.divided_mesh = scene.stem().string() + ".divided.off";
    const ProposedScene proposed = propose_scene(
        fs::proximate(fs::absolute(mesh_).lexically_normal(), folder), surface, choices_);
    for (const std::string& note : proposed.notes) say("  {}", note);
    for (const std::string& doubt : proposed.warnings) warn("{}", doubt);
    const fs::path divided = folder / choices_.divided_mesh;
    const std::string text = proposed.is_divided ? off_text(proposed.surface) : "";
    // One of before, which another scene may name, stays.
    const bool is_made =
        proposed.is_divided && (!fs::exists(divided) || read_whole_file(divided) != text);
    if (is_made) {
      check_output(divided, {}, {});
      write_file_atomically(divided, text);
    }
    write_file_atomically(output_, proposed.text);
    try {
      try_out(open_scene(output_));
    } catch (...) {
      fs::remove(output_);
      if (is_made) fs::remove(divided);
      throw;
    }
    if (is_made) say("wrote {}", divided.string());
    say("wrote {}; next: palpate check {}", output_, output_);
    reply.json = nlohmann::ordered_json{
        {"unit", proposed.unit}, {"tissue", proposed.tissue}, {"notes", proposed.notes}};
    if (proposed.is_divided) reply.json["divided"] = divided.string();
    return kDone;
  }

 private:
  void check_of_scene_alone() const {
    refuse_options({{"--path", is_recordings_ && is_path_},
                    {"--unit", !choices_.unit.empty()},
                    {"--tissue", !choices_.tissue.empty()},
                    {"--held", !choices_.held.empty()},
                    {"--wrap", choices_.wrap}},
                   fmt::format("does nothing with {}", is_recordings_ ? "--recordings" : "--path"));
  }

  // The surface in the file, or the boundary of its tetrahedra with what it marks.
  Surface read_body() {
    if (!is_volume_format(mesh_)) return read_surface(mesh_, 1);
    if (choices_.wrap)
      throw Error("--wrap", "is of a surface, and the mesh is one of tetrahedra", "Leave it out.");
    choices_.is_volume = true;
    choices_.groups = groups_of_tet_mesh(mesh_);
    const TetMesh volume = read_tet_mesh(mesh_, 1);
    return {volume.nodes, fem::boundary_triangles(volume.tets)};
  }

  int write_manifest(Reply& reply) const {
    const ProposedManifest proposed = propose_manifest(mesh_, output_);
    for (const std::string& note : proposed.notes) say("  {}", note);
    for (const std::string& doubt : proposed.warnings) warn("{}", doubt);
    write_file_atomically(output_, proposed.text);
    say("wrote {}; next: palpate check {}", output_, output_);
    reply.json = nlohmann::ordered_json{
        {"files", proposed.files}, {"notes", proposed.notes}, {"doubts", proposed.warnings}};
    return kDone;
  }

  int write_path(Reply& reply) const {
    if (!is_asset_file(mesh_))
      throw Error(mesh_, "is no asset, and --path makes a path for one",
                  "Name the asset.palp that `palpate run` or `export` wrote.");
    const ProposedPath path = propose_path(read_asset_file(mesh_).asset());
    write_tip_path(output_, path.tip);
    say("  down at {}, {:.3g} mm deep, {:.3g} mm across, and up again", in_mm(path.touched),
        1e3 * path.depth_m, 1e3 * path.slide_m);
    say("wrote {}: {} ticks; next: palpate replay {} {} -o forces.csv", output_,
        path.tip.time_s.size(), mesh_, output_);
    reply.json =
        nlohmann::ordered_json{{"ticks", path.tip.time_s.size()},
                               {"touched_m", {path.touched[0], path.touched[1], path.touched[2]}},
                               {"depth_m", path.depth_m},
                               {"slide_m", path.slide_m}};
    return kDone;
  }

  // What `check` does before its trial: what it would refuse is not proposed.
  void try_out(const Scene& scene) const {
    try {
      say("  tried, as check does it:");
      check_choices(scene);
      check_experiments(scene, prepare_body(scene, false));
    } catch (const Error& e) {
      throw Error(mesh_, fmt::format("no scene of it that can be run was found: {}", e.fact()),
                  e.remedy());
    }
  }

  bool is_path_ = false, is_recordings_ = false;
  std::string mesh_, output_;
  SceneChoices choices_;
};

}  // namespace

const CommandRow kNewCommand{"new", "Write a commented scene to start from, for a surface mesh",
                             declared<New>, "Start", "new organ.stl --unit mm -o organ.toml"};

}  // namespace palpate::tools
