// `palpate_bench`: a program of its own, so that what is measured by developers alone is no part of
// what users carry.

#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {
namespace {

using RunBench = void(const BenchRequest&);

template <RunBench* kRun>
class Benchmark final : public Command {
 public:
  explicit Benchmark(Arguments& arguments) {
    arguments.option("-o,--output DIR", folder_, "Folder for tables and pictures");
    arguments.option("--jobs", request_.jobs,
                     "Number of threads of benchmarks that use several; 0 uses all cores");
    arguments.option("--part NAME", request_.part, "Part of the benchmark to run alone");
    arguments.option("--samples", samples_, "reference.h5 of a run, of laws");
    arguments.option("--run", run_, "Folder of `palpate run`, of rivals");
    arguments.option("--packages", packages_,
                     "Folder whose node_modules has @mujoco/mujoco, of rivals");
    arguments.flag("--quick", request_.is_quick, "Use smaller sizes");
  }

  int run(Reply&) override {
    request_.folder = folder_;
    request_.samples = samples_;
    request_.run = run_;
    request_.packages = packages_;
    std::filesystem::create_directories(folder_);
    kRun(request_);
    return kDone;
  }

 private:
  std::string folder_ = "docs/bench", samples_, run_, packages_;
  BenchRequest request_;
};

template <RunBench* kRun>
std::unique_ptr<Command> declare(Arguments& arguments) {
  return std::make_unique<Benchmark<kRun>>(arguments);
}

const CommandRow kBenchmarks[] = {
    {"tick", "Time per engine tick by body size and kind of contact", declare<bench_tick>},
    {"clicks", "The paper's edge clicks: force jumps with each interpolation off",
     declare<bench_clicks>},
    {"fem", "Simulator: force error, time, rates and ratios, by part", declare<bench_fem>},
    {"peers", "The same press by CalculiX, where ccx is installed", declare<bench_peers>},
    {"fit", "Curves per second by rows and test points, beside plain least squares",
     declare<bench_fit>},
    {"rivals", "Force error against time of a tick: Palpate, proxies, linear and coarse bodies",
     declare<bench_rivals>},
    {"laws", "Each contact law at a test point, by kind of path", declare<bench_laws>},
    kPredictCommand,
};

}  // namespace
}  // namespace palpate::tools

int main(int argc, char** argv) {
  using namespace palpate::tools;
  return run_program("palpate_bench", "Measure speed and error, and write tables and pictures",
                     kBenchmarks, argc, argv);
}
