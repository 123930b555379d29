#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/report/contents.hpp"
#include "tools/report/figures.hpp"
#include "tools/report/page.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr NamedOutput kFigures[] = {{"curves.svg", "svg"},
                                    {"error.svg", "svg"},
                                    {"stiffness.svg", "svg"},
                                    {"placement.svg", "svg"}};

class Report final : public Command {
 public:
  explicit Report(Arguments& arguments) {
    arguments.positionals(
        "folder", folders_,
        "Folder of a run, whole or in part, or of a study; further ones are compared with it");
    arguments.output("-o,--output", output_, "Page to write, report.html", {kPageKind},
                     /*is_required=*/false);
    arguments.option("--figures DIR", figures_, "Folder for figures of the first folder, as SVG");
    arguments.named_outputs(figures_, kFigures);
  }

  int run(Reply& reply) override {
    if (output_.empty() && figures_.empty())
      throw Error("report", "neither a page nor figures are wanted",
                  "Give --output report.html, --figures FOLDER, or both.");
    if (std::error_code none;
        !figures_.empty() && fs::exists(figures_, none) && !fs::is_directory(figures_, none))
      throw Error("--figures", figures_ + " is a file", "Name a folder.");
    const std::string contents = contents_of_folders(folders_);
    reply.json = nlohmann::ordered_json{{"folders", folders_}};
    if (!output_.empty()) {
      write_page(output_, contents);
      say("wrote {}: open it in a browser", output_);
    }
    if (!figures_.empty()) {
      const auto names = write_figures(Json::parse(contents), figures_);
      if (names.empty())
        throw Error(folders_.front(), "holds nothing that a figure is made of",
                    "Give the folder of a run with curves.h5 and samples.h5.");
      say("wrote {}: {}", figures_, listed(names));
      reply.json["figures"] = names;
    }
    return kDone;
  }

 private:
  std::vector<std::string> folders_;
  std::string output_, figures_;
};

}  // namespace

std::unique_ptr<Command> declare_report(Arguments& arguments) {
  return std::make_unique<Report>(arguments);
}

}  // namespace palpate::tools
