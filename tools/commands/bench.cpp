#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "libfit/core/error.hpp"
#include "tools/command.hpp"

namespace palpate::tools {
namespace {

// Starts palpate_bench, which lies beside this program, in its place.
class Bench final : public Command {
 public:
  explicit Bench(Arguments& arguments) {
    arguments.remaining(arguments_, "of palpate_bench; --help lists them");
  }

  int run(Reply& reply) override {
    std::error_code ignored;
    const auto program =
        std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / "palpate_bench";
    std::string name = program.string();
    std::vector<char*> line{name.data()};
    for (std::string& argument : arguments_) line.push_back(argument.data());
    line.push_back(nullptr);
    execv(name.c_str(), line.data());  // returns only when it failed
    const std::string fact = "cannot start " + name + ": " + std::strerror(errno);
    const std::string remedy =
        "Configure with -DPALPATE_WORKSHOP=ON and build the target palpate_bench.";
    if (!asks_for_help()) throw Error("bench", fact, remedy);
    reply.text =
        "Benchmarks are a program of their own, which lists them: " + fact + ".\n" + remedy;
    return kDone;
  }

 private:
  bool asks_for_help() const {
    return std::ranges::any_of(arguments_, [](const std::string& argument) {
      return argument == "--help" || argument == "-h";
    });
  }

  std::vector<std::string> arguments_;
};

}  // namespace

std::unique_ptr<Command> declare_bench(Arguments& arguments) {
  return std::make_unique<Bench>(arguments);
}

}  // namespace palpate::tools
