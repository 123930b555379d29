
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/crash_report.hpp"
#include "tools/outputs.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/simulate.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

// Brings a stage's output up to date. Returns whether it was made.
bool bring_up_to_date(const StageRow& stage, Pipeline& pipeline, bool force) {
  set_stage(stage.name);
  const std::string output = (pipeline.files.*stage.output).string(),
                    wanted = stage.wanted(pipeline);
  const auto stored = stage.stored ? stage.stored(pipeline) : stored_in_hdf5(output);
  if (!force && stored == wanted) {
    say("{:<9}{} is up to date", stage.name, output);
    if (stage.load) stage.load(pipeline, wanted);
    return false;
  }
  say("{:<9}{}", stage.name, output);
  stage.make(pipeline, wanted);
  if (stage.say) stage.say(pipeline);
  return true;
}

// Returns how many stages were made. Stages with one summary share a line beside the log.
int run_stages(const std::vector<const StageRow*>& stages, Pipeline& pipeline, bool force,
               RunLog* log) {
  int done = 0;
  for (auto stage = stages.begin(); stage != stages.end();) {
    const char* const summary = (*stage)->summary;
    const int before = done;
    const double from_s = wall_seconds();
    for (; stage != stages.end() && (*stage)->summary == summary; ++stage)
      done += bring_up_to_date(**stage, pipeline, force);
    if (log != nullptr)
      log->say_summary(fmt::format(
          "{:<21}{}", summary, done == before ? "up to date" : in_words(wall_seconds() - from_s)));
  }
  return done;
}

}  // namespace

RunResult run(const RunRequest& request, RunLog* log) {
  const bool is_of_recordings = is_manifest(request.scene);
  if (is_of_recordings && request.quick)
    throw Error("--quick", "is of scenes, and " + request.scene + " is a manifest of recordings",
                "Leave it out: recordings are not simulated, and a run of them takes a minute.");
  OutputFolder folder(request.folder);
  Pipeline pipeline{
      .files = files_in(request.folder), .jobs = request.jobs, .resume = !request.force};
  const auto open_folder = [&] {
    folder.claim();
    if (log) log->open(fs::path(request.folder) / kRunLog, "palpate run " + request.scene);
  };
  if (is_of_recordings) {
    pipeline.import = {read_manifest(request.scene), pipeline.files.samples, request.jobs, true};
    check_recordings_exist(pipeline.import.manifest);
    pipeline.fit = pipeline.import.manifest.fit;
    open_folder();
  } else {
    pipeline.scene = open_scene(request.scene);
    if (request.quick) make_quick(pipeline.scene);
    check_choices(pipeline.scene);
    pipeline.fit = pipeline.scene.fit;
    pipeline.before_writing = open_folder;
  }
  RunResult result;
  result.stages_done = run_stages(is_of_recordings ? stages_of_recordings() : stages_of_scene(),
                                  pipeline, request.force, log);
  if (result.stages_done == 0) say("nothing to do: everything in {} is up to date", request.folder);
  const StageFiles& files = pipeline.files;
  result.statement =
      validation::parse_statement(read_whole_file(files.statement), files.statement.string());
  if (!pipeline.bad_experiments)
    pipeline.bad_experiments = list_bad_experiments(read_samples(files.samples));
  result.items_failed =
      *pipeline.bad_experiments + list_bad_points(read_curves(files.curves), request.quick);
  if (!is_of_recordings) result.items_failed += result.statement.reference_failures;
  return result;
}

}  // namespace palpate::tools
