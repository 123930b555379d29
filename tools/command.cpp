#include "tools/command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>

#include "libfit/core/error.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/nearest_name.hpp"

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
    texts_.push_back(&target);
  }
  void positionals(const std::string& name, std::vector<std::string>& targets,
                   const std::string& help) override {
    app_.add_option(name, targets, help)->required();
  }
  void option(const std::string& flags, std::string& target, const std::string& help,
              bool is_required) override {
    auto* option = app_.add_option(flags, target, help);
    if (is_required) option->required();
    if (!target.empty()) option->capture_default_str();
    texts_.push_back(&target);
  }
  void output(const std::string& flags, std::string& target, const std::string& help,
              std::initializer_list<std::string_view> kinds, bool is_required) override {
    auto* option = app_.add_option(flags, target, help);
    if (is_required) option->required();
    outputs_.push_back({&target, kinds});
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
    takes_all_ = true;
  }

  bool is_parsed() const { return app_.parsed(); }

  /// The nearest option where the command has none of this name; nothing where it has.
  std::optional<std::string> unknown_option(std::string_view typed) const {
    if (takes_all_) return std::nullopt;
    std::vector<std::string> known;
    for (const CLI::Option* option : app_.get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    if (std::find(known.begin(), known.end(), typed) != known.end()) return std::nullopt;
    return nearest_name(typed, {known.begin(), known.end()});
  }

  void check_outputs() const {
    std::vector<std::string> inputs;
    for (const std::string* text : texts_) inputs.push_back(*text);
    for (const auto& [target, kinds] : outputs_)
      if (!target->empty()) check_output(*target, kinds, inputs);
  }

 private:
  struct OutputFile {
    const std::string* target;
    std::vector<std::string_view> kinds;
  };

  CLI::App& app_;
  std::vector<const std::string*> texts_;
  std::vector<OutputFile> outputs_;
  bool takes_all_ = false;
};

struct DeclaredCommand {
  std::unique_ptr<CliArguments> arguments;
  std::unique_ptr<Command> command;
};

// Says what was meant where the first word is no command, or an option none of the command's.
// CLI11 would complain of what is missing instead.
bool is_misspelt(const CLI::App& app, std::span<const CommandRow> rows,
                 const std::map<std::string, DeclaredCommand>& declared, std::span<char*> words) {
  const auto say_unknown = [&](std::string_view command, std::string_view what,
                               std::string_view nearest) {
    say("palpate: error: {}: {}\n  {}See {} {}--help.", words[0], what,
        nearest.empty() ? "" : fmt::format("Did you mean \"{}\"? ", nearest), app.get_name(),
        command);
    return true;
  };
  if (words.empty()) return fmt::print(stderr, "{}", app.help()), true;
  if (words[0][0] == '-') return false;
  const auto found = declared.find(words[0]);
  if (found == declared.end()) {
    std::vector<std::string_view> names;
    for (const CommandRow& row : rows) names.push_back(row.name);
    return say_unknown("", "there is no such command", nearest_name(words[0], names));
  }
  for (const std::string_view word : words.subspan(1)) {
    if (word == "--") break;
    if (!word.starts_with("--")) continue;
    const std::string_view name = word.substr(0, word.find('='));
    if (const auto nearest = found->second.arguments->unknown_option(name))
      return say_unknown(fmt::format("{} ", words[0]), fmt::format("has no option {}", name),
                         *nearest);
  }
  return false;
}

int run_command(CLI::App& app, std::span<const CommandRow> rows, int argc, char** argv) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "palpate " PALPATE_VERSION);
  std::map<std::string, DeclaredCommand> declared;
  for (const CommandRow& row : rows) {
    auto arguments = std::make_unique<CliArguments>(
        *app.add_subcommand(std::string(row.name), std::string(row.summary)));
    auto command = row.declare(*arguments);
    declared[std::string(row.name)] = {std::move(arguments), std::move(command)};
  }
  if (is_misspelt(app, rows, declared, {argv + 1, static_cast<std::size_t>(argc - 1)}))
    return kWrongUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // CLI11 has exit codes of its own (105-110); ours are a contract.
    return app.exit(e) == 0 ? kDone : kWrongUsage;
  }
  for (auto& [name, row] : declared)
    if (row.arguments->is_parsed()) {
      row.arguments->check_outputs();
      return row.command->run();
    }
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
  } catch (const std::filesystem::filesystem_error& e) {
    std::fprintf(stderr,
                 "palpate: error: %s: %s\n  Check the name, the permissions and the space.\n",
                 e.path1().c_str(), e.code().message().c_str());
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
