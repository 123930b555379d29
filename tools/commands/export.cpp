#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

class Export final : public Command {
 public:
  explicit Export(Arguments& arguments) {
    arguments.positional("model", model_, "Model to export, model.h5");
    arguments.output("-o,--output", output_,
                     "File to write, in the format of its name: asset.palp, or .vtu, .glb, .ply",
                     {"palp", "vtu", "glTF", "ply"});
    arguments.option("--format NAME", format_, "Format that the name of the file must have");
    arguments.option("--depth LEN", depth_,
                     "Depth at which glb and ply show the stiffness, such as \"5 mm\"; half of the "
                     "curves' range if not given");
    arguments.option("--engine DIR", engine_, "Folder to copy the engine and its example into");
    arguments.option("--scene", scene_, "scene.toml whose [tool] is taken, as run takes it");
  }

  int run(Reply& reply) override {
    const std::string format = settled_format();
    Pipeline stage{.files = {.model = model_, .asset = output_, .engine = engine_}};
    if (!scene_.empty()) stage.scene = open_scene(scene_);
    if (!engine_.empty() && format != "palp")
      throw Error("--engine", "says nothing of a " + format, "Leave it out, or export palp.");
    if (!depth_.empty() && format != "glb" && format != "ply")
      throw Error("--depth", format + " has every depth", "Leave it out, or export glb or ply.");
    if (std::error_code none; !engine_.empty() && std::filesystem::exists(engine_, none) &&
                              !std::filesystem::is_directory(engine_, none))
      throw Error("--engine", engine_ + " is a file", "Name a folder.");
    stage.exported_format = format;
    stage.map_depth_m = depth_m();
    remake(kExportStage, stage);
    const ExportReport& report = stage.exported;
    reply.json = nlohmann::ordered_json{{"vertices", report.vertices},
                                        {"triangles", report.triangles},
                                        {"mean_vertices", report.mean_vertices},
                                        {"remarks", report.remarks}};
    return kDone;
  }

 private:
  std::string settled_format() const {
    if (!format_.empty()) find_exporter(format_);
    const Exporter& named = exporter_of_file(output_);
    if (!format_.empty() && format_ != named.name)
      throw Error(
          "--format",
          fmt::format("is {}, and {} is the name of a {} file", format_, output_, named.name),
          fmt::format("Leave it out, or let the name end in {}.",
                      find_exporter(format_).extension));
    return std::string(named.name);
  }
  double depth_m() const {
    if (depth_.empty()) return 0;
    const auto depth = parse_quantity(depth_, Dimension::length);
    if (!depth || !(*depth > 0))
      throw Error("--depth", "\"" + depth_ + "\" is no depth", "Give a length such as \"5 mm\".");
    return *depth;
  }

  std::string model_, output_, format_, engine_, depth_, scene_;
};

}  // namespace

std::unique_ptr<Command> declare_export(Arguments& arguments) {
  return std::make_unique<Export>(arguments);
}

}  // namespace palpate::tools
