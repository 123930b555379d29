#include "tools/stages/export.hpp"

#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"

namespace palpate::tools {
namespace {

class Export final : public Command {
 public:
  explicit Export(Arguments& arguments) {
    arguments.positional("model", model_, "Model to export, model.h5");
    arguments.output("-o,--output", output_, "File to write, such as asset.palp", {"palp", "vtu"});
    arguments.option("--format", format_, "Format to write: palp or vtu");
    arguments.option("--engine", engine_, "Folder to copy the engine and its example into");
    arguments.option("--elsewhere", settings_.elsewhere,
                     "What surface without test points answers with: mean, the body's mean curves, "
                     "flagged as OUTSIDE, or none");
    arguments.flag("--no-guard", no_guard_,
                   "Let the engine carry out slips that would create energy");
  }

  int run(Reply& reply) override {
    if (no_guard_) settings_.guard = false;
    const ExportReport report = export_model(read_model(model_), output_, format_,
                                             {.settings = settings_,
                                              .fingerprint = asset_fingerprint(settings_, model_),
                                              .statement = {},
                                              .engine = engine_});
    reply.json = nlohmann::ordered_json{{"vertices", report.vertices},
                                        {"triangles", report.triangles},
                                        {"mean_vertices", report.mean_vertices},
                                        {"remarks", report.remarks}};
    return kDone;
  }

 private:
  std::string model_, output_, format_ = "palp", engine_;
  ExportSection settings_;
  bool no_guard_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_export(Arguments& arguments) {
  return std::make_unique<Export>(arguments);
}

}  // namespace palpate::tools
