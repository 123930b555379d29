#include "tools/stages/import.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"

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
    arguments.option("--jobs", request_.jobs,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--drop-invalid", request_.drop_invalid,
                   "Leave out rows that are not numbers or go back in time, and count them");
    arguments.flag("--force", force_, "Replace files beside the output that Palpate did not write");
  }

  int run(Reply& reply) override {
    request_.manifest = manifest_;
    request_.output = output_;
    const ImportResult result = write_recordings(request_, read_recordings(request_));
    reply.json = result.json;
    return result.refused > 0 ? kSomeFailed : kDone;
  }

 private:
  std::string manifest_, output_;
  bool force_ = false;  // of Arguments, which looks for it
  ImportRequest request_;
};

}  // namespace

std::unique_ptr<Command> declare_import(Arguments& arguments) {
  return std::make_unique<Import>(arguments);
}

}  // namespace palpate::tools
