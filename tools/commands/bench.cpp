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
    const bool asks_for_help = std::ranges::any_of(
        arguments_, [](const std::string& word) { return word == "--help" || word == "-h"; });
    if (!asks_for_help) throw Error("bench", fact, remedy);
    reply.text =
        "Benchmarks are a program of their own, which lists them: " + fact + ".\n" + remedy;
    return kDone;
  }

 private:
  std::vector<std::string> arguments_;
};

}  // namespace

const CommandRow kBenchCommand{"bench", "Measure speed and error, and write tables and pictures",
                               declared<Bench>, "Studies", "bench tick -o bench"};

}  // namespace palpate::tools
