#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "libfit/core/error.hpp"
#include "tools/bench/bench.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

constexpr std::array kBenchmarks{
    Benchmark{"tick", "time per engine tick by body size and kind of contact", bench_tick},
    Benchmark{"clicks", "the paper's edge clicks: force jumps with each interpolation off",
              bench_clicks},
    Benchmark{"fem", "simulator: force error, time, rates and ratios, by part", bench_fem},
    Benchmark{"peers", "the same press by CalculiX, where ccx is installed", bench_peers},
    Benchmark{"refine", "curves of a thousand test points on up to a million vertices",
              bench_refine},
    Benchmark{"fit", "curves per second by rows and test points, beside plain least squares",
              bench_fit},
    Benchmark{"curves", "error of rows held out against pieces, degree, bytes and time",
              bench_curves},
};

std::string names() {
  std::string out;
  for (const Benchmark& row : kBenchmarks) out += (out.empty() ? "" : ", ") + std::string(row.name);
  return out;
}

class Bench final : public Command {
 public:
  explicit Bench(Arguments& arguments) {
    std::string help = "which:";
    for (const Benchmark& row : kBenchmarks) help += fmt::format(" {} ({})", row.name, row.summary);
    arguments.positional("benchmark", name_, help);
    arguments.option("-o,--output", folder_, "folder for tables and pictures");
    arguments.option("--jobs", jobs_, "threads, where the benchmark has any; 0: all cores");
    arguments.option("--part", part_, "of a benchmark that has parts, such as fem: this one alone");
    arguments.option("--samples", samples_, "samples.h5, for curves");
    arguments.flag("--quick", is_quick_, "smaller sizes, for a look");
  }

  int run() override {
    const auto row = std::find_if(kBenchmarks.begin(), kBenchmarks.end(),
                                  [&](const Benchmark& b) { return b.name == name_; });
    if (row == kBenchmarks.end())
      throw Error("bench", "there is no benchmark called " + name_,
                  "Choose one of: " + names() + ".");
    std::filesystem::create_directories(folder_);
    row->run({folder_, jobs_, part_, samples_, is_quick_});
    return kDone;
  }

 private:
  std::string name_, folder_ = "docs/bench", part_, samples_;
  int jobs_ = 0;
  bool is_quick_ = false;
};

}  // namespace

std::span<const Benchmark> benchmarks() { return kBenchmarks; }

std::unique_ptr<Command> declare_bench(Arguments& arguments) {
  return std::make_unique<Bench>(arguments);
}

}  // namespace palpate::tools
