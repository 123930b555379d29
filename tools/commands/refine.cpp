#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/stage_table.hpp"

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
    Pipeline stage;
    stage.files = {.body = body_, .samples = samples_, .curves = curves_, .model = output_};
    remake(kRefineStage, stage);
    say("wrote {}", output_);
    const Model model = read_model(output_);
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
