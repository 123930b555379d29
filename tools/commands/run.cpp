#include <nlohmann/json.hpp>

#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/report/report_page.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

// What a run leaves in its folder; its engine looks after itself.
constexpr NamedOutput kFiles[] = {
    {"body.h5", kBodySchema.name},
    {"placed.h5", kBodySchema.name},
    {"placement.csv", "points,new_points"},
    {"samples.h5", kSamplesSchema.name},
    {"samples.surface.h5", kSurfaceSchema.name},
    {"samples.signals.h5", kSignalsSchema.name},
    {"samples.held_out.h5", kSamplesSchema.name},
    {"samples.import.csv", "file,line,recording"},
    {"samples.import.json", "{\"files\":"},
    {"body.obj", "# palpate surface"},
    {"curves.h5", kCurvesSchema.name},
    {"model.h5", kModelSchema.name},
    {"asset.palp", "palp"},
    {"reference.h5", kSamplesSchema.name},
    {"validation.csv", "point,path,step"},
    {"statement.json", "{\"force_error\":"},
    {"report.html", kPageKind},
    {kRunLog, "palpate run "},
};

class Run final : public Command {
 public:
  explicit Run(Arguments& arguments) {
    arguments.positional("scene", request_.scene,
                         "Scene to read, scene.toml, or manifest of recordings, manifest.toml");
    arguments.option("-o,--output DIR", request_.folder, "Folder for all files of the run", true);
    arguments.jobs(request_.jobs);
    arguments.named_outputs(request_.folder, kFiles);
    arguments.flag("--force", request_.force,
                   "Repeat every stage, also those whose inputs have not changed, and replace "
                   "files that Palpate did not write");
    arguments.flag("--quick", request_.quick,
                   "A first answer within minutes: few points and rows, and a statement of what "
                   "that is worth");
  }

  int run(Reply& reply) override {
    RunLog log;
    const RunResult result = tools::run(request_, &log);
    say("{}", validation::in_words(result.statement));
    reply.text = validation::verdict(result.statement);
    for (const std::string& sentence : validation::advice(result.statement))
      reply.text += '\n' + sentence;
    reply.text += "\nnext: " + report();
    reply.json = nlohmann::ordered_json{
        {"folder", request_.folder},
        {"stages_done", result.stages_done},
        {"items_failed", result.items_failed},
        {"statement", nlohmann::ordered_json::parse(validation::to_json(result.statement))}};
    return result.items_failed ? kSomeFailed : kDone;
  }

 private:
  // The page to look at, where it is installed; says what to do next.
  std::string report() {
    const std::filesystem::path output = std::filesystem::path(request_.folder) / "report.html";
    if (find_page()) {
      write_page(output, contents_of_folder(request_.folder));
      return fmt::format("open {} in a browser and press the body", output.string());
    }
    return fmt::format(
        "build the page (Node.js 18 or newer with npm; target palpate_page), then `palpate report "
        "{} -o report.html`",
        request_.folder);
  }

  RunRequest request_;
};

class Report final : public Command {
 public:
  explicit Report(Arguments& arguments) {
    arguments.positional("folder", folder_, "Folder of a run, whole or in part");
    arguments.output("-o,--output", output_, "Page to write, report.html", {kPageKind});
  }

  int run(Reply& reply) override {
    write_page(output_, contents_of_folder(folder_));
    say("wrote {}: open it in a browser", output_);
    reply.json = nlohmann::ordered_json{{"folder", folder_}};
    return kDone;
  }

 private:
  std::string folder_, output_;
};

}  // namespace

const CommandRow kRunCommand{"run",
                             "Run all stages, or those still missing, from a scene or recordings "
                             "to an asset and its error statement",
                             declared<Run>, "Start", "run organ.toml -o out --quick"};
const CommandRow kReportCommand{
    "report", "Write a page to look at: errors, the body, its curves, and the body to poke",
    declared<Report>, "Start", "report out -o report.html"};

}  // namespace palpate::tools
