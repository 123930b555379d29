#include <nlohmann/json.hpp>

#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/report/report_page.hpp"

namespace palpate::tools {
namespace {

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

std::unique_ptr<Command> declare_report(Arguments& arguments) {
  return std::make_unique<Report>(arguments);
}

}  // namespace palpate::tools
