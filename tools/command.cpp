#include "tools/command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "libfit/core/error.hpp"
#include "tools/console.hpp"

// Present when the BLAS is OpenBLAS.
extern "C" int blas_thread_shutdown_(void) __attribute__((weak));

namespace palpate::tools {
namespace {

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

int run_command(CLI::App& app, std::span<const CommandRow> rows, int argc, char** argv) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "palpate " PALPATE_VERSION);
  std::vector<std::pair<CLI::App*, std::unique_ptr<Command>>> declared;
  for (const CommandRow& row : rows) {
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

int run_program(const char* name, const char* summary, std::span<const CommandRow> rows, int argc,
                char** argv) {
  // OpenBLAS starts a thread per core when it is loaded, and they spin; here each point has one.
  if (blas_thread_shutdown_) blas_thread_shutdown_();
  catch_interrupts();
  try {
    CLI::App app(summary, name);
    return run_command(app, rows, argc, argv);
  } catch (const Interrupted& e) {
    std::fprintf(stderr, "palpate: interrupted: %s\n", e.what());
    return kInterrupted;
  } catch (const Error& e) {
    std::fprintf(stderr, "palpate: error: %s\n", e.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr,
                 "palpate: error: memory: there is not enough of it\n  Use fewer --jobs or a "
                 "coarser mesh.\n");
    return kBadInput;
  } catch (const std::exception& e) {
    std::fprintf(
        stderr,
        "palpate: error: internal: %s\n  Please report this with the command that caused it.\n",
        e.what());
    return kBadInput;
  }
}

}  // namespace palpate::tools
