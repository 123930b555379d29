#include "libfit/io/files/files.hpp"
#include "libfit/io/files/signals_file.hpp"
#include "tools/command.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

constexpr NamedOutput kBeside[] = {{".held_out.h5", kSamplesSchema.name},
                                   {".signals.h5", kSignalsSchema.name},
                                   {".import.csv", "file,line,recording"},
                                   {".import.json", "{\"files\":"},
                                   {".relaxation.import.csv", "file,point,time_s"}};

class Import final : public Command {
 public:
  explicit Import(Arguments& arguments) {
    arguments.positional("manifest", manifest_,
                         "Manifest of the recordings and how to read them, manifest.toml");
    arguments.output("-o,--output", output_,
                     "samples.h5 to write, with samples.signals.h5, samples.import.csv and .json "
                     "beside it",
                     {kSamplesSchema.name});
    arguments.named_outputs(output_, kBeside);
    arguments.option("--jobs", stage_.import.jobs,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--drop-invalid", stage_.import.drop_invalid,
                   "Leave out rows that are not numbers or go back in time, and count them");
    arguments.flag("--force", force_, "Replace files beside the output that Palpate did not write");
  }

  int run(Reply& reply) override {
    stage_.import.manifest = manifest_;
    stage_.import.output = output_;
    remake(kImportStage, stage_);
    reply.json = stage_.imported;
    return *stage_.bad_experiments > 0 ? kSomeFailed : kDone;
  }

 private:
  std::string manifest_, output_;
  bool force_ = false;  // of Arguments, which looks for it
  Pipeline stage_;
};

}  // namespace

std::unique_ptr<Command> declare_import(Arguments& arguments) {
  return std::make_unique<Import>(arguments);
}

}  // namespace palpate::tools
