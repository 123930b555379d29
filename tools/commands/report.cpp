#include <nlohmann/json.hpp>

#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/report/contents.hpp"
#include "tools/report/page.hpp"

namespace palpate::tools {
namespace {

class Report final : public Command {
 public:
  explicit Report(Arguments& arguments) {
    arguments.positionals(
        "folder", folders_,
        "Folder of a run, whole or in part, or of a study; further ones are compared with it");
    arguments.output("-o,--output", output_, "Page to write, report.html", {kPageKind});
  }

  int run(Reply& reply) override {
    write_page(output_, contents_of_folders(folders_));
    say("wrote {}: open it in a browser", output_);
    reply.json = nlohmann::ordered_json{{"folders", folders_}};
    return kDone;
  }

 private:
  std::vector<std::string> folders_;
  std::string output_;
};

}  // namespace

std::unique_ptr<Command> declare_report(Arguments& arguments) {
  return std::make_unique<Report>(arguments);
}

}  // namespace palpate::tools
