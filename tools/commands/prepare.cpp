#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

class Prepare final : public Command {
 public:
  explicit Prepare(Arguments& arguments) {
    arguments.positional("scene", scene_, "Scene to read, scene.toml");
    arguments.output("-o,--output", output_, "body.h5 to write", {kBodySchema.name});
    arguments.flag("--surface-only", stage_.surface_only,
                   "Make no volume mesh, which is enough for measured data and for open surfaces");
  }

  int run(Reply& reply) override {
    stage_.scene = open_scene(scene_);
    stage_.files.body = output_;
    say("prepare {}", scene_);
    kPrepareStage.make(stage_, stage_.surface_only ? "" : kPrepareStage.wanted(stage_));
    say("wrote {}", output_);
    const Body& body = stage_.body;
    reply.json = nlohmann::ordered_json{{"vertices", body.surface.vertices.rows()},
                                        {"tets", body.volume.tets.rows()},
                                        {"test_points", body.test_points.position.rows()}};
    return kDone;
  }

 private:
  std::string scene_, output_;
  Pipeline stage_;
};

}  // namespace

std::unique_ptr<Command> declare_prepare(Arguments& arguments) {
  return std::make_unique<Prepare>(arguments);
}

}  // namespace palpate::tools
