#include "tools/stages/body/prepare.hpp"
#include "tools/stages/body/open_scene.hpp"

#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"

namespace palpate::tools {
namespace {

class Prepare final : public Command {
 public:
  explicit Prepare(Arguments& arguments) {
    arguments.positional("scene", scene_, "Scene to read, scene.toml");
    arguments.output("-o,--output", output_, "body.h5 to write", {kBodySchema.name});
    arguments.flag("--surface-only", surface_only_,
                   "Make no volume mesh, which is enough for measured data and for open surfaces");
  }

  int run(Reply& reply) override {
    const Scene scene = open_scene(scene_);
    say("prepare {}", scene_);
    const Body body = prepare_body(scene, surface_only_);
    if (!surface_only_) check_experiments(scene, body);
    write_body(
        output_, body,
        surface_only_ ? Attributes{} : Attributes{{kInputsAttribute, body_fingerprint(scene)}});
    say("wrote {}", output_);
    reply.json = nlohmann::ordered_json{{"vertices", body.surface.vertices.rows()},
                                        {"tets", body.volume.tets.rows()},
                                        {"test_points", body.test_points.position.rows()}};
    return kDone;
  }

 private:
  std::string scene_, output_;
  bool surface_only_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_prepare(Arguments& arguments) {
  return std::make_unique<Prepare>(arguments);
}

}  // namespace palpate::tools
