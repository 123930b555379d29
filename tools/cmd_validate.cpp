#include <fmt/format.h>

#include "libfit/core/error.hpp"
#include "libfit/io/body_file.hpp"
#include "tools/check_scene.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stage_prepare.hpp"
#include "tools/stage_validate.hpp"

namespace palpate::tools {
namespace {

class Validate final : public Command {
 public:
  explicit Validate(Arguments& arguments) {
    arguments.positional("asset", asset_, "asset.palp");
    arguments.positional("scene", scene_, "scene.toml that the reference simulates");
    arguments.option("--points", request_.points, "Contact points");
    arguments.option("--seed", request_.seed, "Seed of the points and paths");
    arguments.option("--jobs", request_.jobs, "Threads; 0: all cores");
    arguments.option("--body", body_, "body.h5 of the scene, where it is at hand");
    arguments.option("--rows", rows_, "CSV of every compared row");
    arguments.flag("--json", json_, "One JSON object on stdout and nothing else there");
  }

  int run() override {
    if (request_.points < 1)
      throw Error("--points", "there must be at least one contact point",
                  "Give a positive number.");
    const Scene scene = read_scene(scene_);
    check_choices(scene);
    const Body body = body_.empty() ? prepare_body(scene, false) : read_body(body_);
    check_experiments(scene, body);
    request_.rows_csv = rows_;
    const Statement statement = validate_asset(asset_, scene, body, request_);
    fmt::print("{}\n", json_ ? to_json(statement) : in_words(statement));
    return statement.reference_failures ? kSomeFailed : kDone;
  }

 private:
  std::string asset_, scene_, body_, rows_;
  ValidateRequest request_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_validate(Arguments& arguments) {
  return std::make_unique<Validate>(arguments);
}

}  // namespace palpate::tools
