#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <new>

#include "libfit/core/error.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"

// Present when the BLAS is OpenBLAS.
extern "C" int blas_thread_shutdown_(void) __attribute__((weak));

namespace palpate::tools {
namespace {

constexpr std::array<CommandRow, 13> kCommands{{
    {"run",
     "Run all stages, or those still missing, from a scene to an asset and its error statement",
     declare_run},
    {"prepare", "Repair a surface, place test points on it and fill it with tetrahedra",
     declare_prepare},
    {"simulate", "Simulate presses and drags of the probe at every test point", declare_simulate},
    {"import", "Turn the recordings that a manifest names into samples", declare_import},
    {"fit", "Identify response curves at the test points", declare_fit},
    {"refine", "Interpolate the curves onto every vertex of the fine surface", declare_refine},
    {"export", "Write a model as a runtime asset or in another format", declare_export},
    {"replay", "Play a tool path on an asset and write the forces", declare_replay},
    {"validate", "Compare an asset with fresh simulated experiments", declare_validate},
    {"predict", "Compare a model with experiments at points where it was not fitted",
     declare_predict},
    {"inspect", "Print what a file holds", declare_inspect},
    {"tabulate", "Write curves as a table", declare_tabulate},
    {"bench", "Measure speed and error, and write tables and pictures", declare_bench},
}};

// Declares a command's options on a CLI11 subcommand.
class CliArguments final : public Arguments {
 public:
  explicit CliArguments(CLI::App& app) : app_(app) {}
  void positional(const std::string& name, std::string& target, const std::string& help) override {
    app_.add_option(name, target, help)->required();
  }
  void option(const std::string& flags, std::string& target, const std::string& help,
              bool is_required) override {
    auto* option = app_.add_option(flags, target, help);
    if (is_required) option->required();
    if (!target.empty()) option->capture_default_str();
  }
  void option(const std::string& flags, int& target, const std::string& help) override {
    app_.add_option(flags, target, help)->capture_default_str();
  }
  void flag(const std::string& flags, bool& target, const std::string& help) override {
    app_.add_flag(flags, target, help);
  }
  void remaining(std::vector<std::string>& target, const std::string& help) override {
    app_.prefix_command();
    app_.set_help_flag();
    app_.footer("Arguments " + help);
    app_.callback([this, &target] { target = app_.remaining(); });
  }

 private:
  CLI::App& app_;
};

int run_program(int argc, char** argv) {
  CLI::App app(
      "Palpate turns soft bodies, simulated or measured, into force-deflection curves for "
      "real-time haptics");
  app.require_subcommand(1);
  app.set_version_flag("--version", "palpate " PALPATE_VERSION);
  std::vector<std::pair<CLI::App*, std::unique_ptr<Command>>> declared;
  for (const CommandRow& row : kCommands) {
    CLI::App* sub = app.add_subcommand(std::string(row.name), std::string(row.summary));
    CliArguments arguments(*sub);
    declared.emplace_back(sub, row.declare(arguments));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // CLI11 has exit codes of its own (105-110); ours are a contract.
    return app.exit(e) == 0 ? kDone : kWrongUsage;
  }
  for (auto& [sub, command] : declared)
    if (sub->parsed()) return command->run();
  return kWrongUsage;
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
  } catch (const Error& e) {
    std::fprintf(stderr, "palpate: error: %s\n", e.what());
    return tools::kBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr,
                 "palpate: error: memory: there is not enough of it\n  Use fewer --jobs or a "
                 "coarser mesh.\n");
    return tools::kBadInput;
  } catch (const std::exception& e) {
    std::fprintf(
        stderr,
        "palpate: error: internal: %s\n  Please report this with the command that caused it.\n",
        e.what());
    return tools::kBadInput;
  }
}
