#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/refine.hpp"

namespace palpate::tools {
namespace {

class Refine final : public Command {
 public:
  explicit Refine(Arguments& arguments) {
    arguments.positional("curves", curves_, "Curves to interpolate, curves.h5");
    arguments.option("--body", body_, "body.h5 whose surface the curves are interpolated onto",
                     true);
    arguments.option("--samples", samples_,
                     "samples.h5 of the curves: what tells how contacts feel each other, and with "
                     "samples.surface.h5 beside it how the surface moves");
    arguments.output("-o,--output", output_, "model.h5 to write", {kModelSchema.name});
  }

  int run(Reply& reply) override {
    say("refine {}", curves_);
    const std::string made_from = model_fingerprint(curves_, body_, samples_);
    const Body body = read_body(body_);
    const bool is_of_scene = !body.scene.empty();
    const Scene scene = is_of_scene ? scene_of(body, body_) : Scene();
    const FittedCurves curves = read_curves(curves_);
    const Model model =
        refine_body(curves, body, samples_.empty() ? Samples() : read_known(samples_),
                    is_of_scene ? &scene : nullptr);
    write_model(output_, model, model_attributes(curves, made_from));
    say("wrote {}", output_);
    const auto covered = std::count(model.is_covered.begin(), model.is_covered.end(), 1);
    reply.json =
        nlohmann::ordered_json{{"vertices", model.is_covered.size()}, {"covered", covered}};
    return kDone;
  }

 private:
  std::string curves_, body_, samples_, output_;
};

}  // namespace

std::unique_ptr<Command> declare_refine(Arguments& arguments) {
  return std::make_unique<Refine>(arguments);
}

}  // namespace palpate::tools
