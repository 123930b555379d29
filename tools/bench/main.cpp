// `palpate_bench`: a program of its own, so that what is measured by developers alone is no part of
// what users carry. `palpate bench` starts it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>

#include "libfit/core/error.hpp"
#include "tools/bench/bench.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"

// Present when the BLAS is OpenBLAS.
extern "C" int blas_thread_shutdown_(void) __attribute__((weak));

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
    Benchmark{"curves", "error of held-out rows against pieces, degree, bytes and time",
              bench_curves},
    Benchmark{"laws", "each contact law at a test point, by kind of path", bench_laws},
};

int run_program(int argc, char** argv) {
  std::string names, which = "Benchmark to run:", name, folder = "docs/bench", part, samples;
  int jobs = 0;
  bool is_quick = false;
  for (const Benchmark& row : kBenchmarks) {
    names += (names.empty() ? "" : ", ") + std::string(row.name);
    which += fmt::format(" {} ({})", row.name, row.summary);
  }
  CLI::App app("Measure speed and error, and write tables and pictures", "palpate bench");
  app.add_option("benchmark", name, which)->required();
  app.add_option("-o,--output", folder, "Folder for tables and pictures")->capture_default_str();
  app.add_option("--jobs", jobs,
                 "Number of threads of benchmarks that use several; 0 uses all cores")
      ->capture_default_str();
  app.add_option("--part", part, "Part of the benchmark to run alone, such as ripple of fem");
  app.add_option("--samples", samples,
                 "samples.h5 that the benchmark curves fits, reference_own.h5 of laws");
  app.add_flag("--quick", is_quick, "Use smaller sizes");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kWrongUsage;
  }
  const auto row = std::find_if(kBenchmarks.begin(), kBenchmarks.end(),
                                [&](const Benchmark& b) { return b.name == name; });
  if (row == kBenchmarks.end())
    throw Error("bench", "there is no benchmark called " + name, "Choose one of: " + names + ".");
  std::filesystem::create_directories(folder);
  row->run({folder, jobs, part, samples, is_quick});
  return kDone;
}

}  // namespace
}  // namespace palpate::tools

int main(int argc, char** argv) {
  using namespace palpate;
  // OpenBLAS starts a thread per core when it is loaded, and they spin; here each point has one.
  if (blas_thread_shutdown_) blas_thread_shutdown_();
  tools::catch_interrupts();
  try {
    return tools::run_program(argc, argv);
  } catch (const tools::Interrupted& e) {
    std::fprintf(stderr, "palpate: interrupted: %s\n", e.what());
    return tools::kInterrupted;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "palpate: error: %s\n", e.what());
    return tools::kBadInput;
  }
}
