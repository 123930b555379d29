#pragma once

#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/outputs.hpp"

namespace palpate::tools {

/// Exit statuses, a contract (docs/formats/commands.md).
enum ExitStatus : int {
  kDone = 0,
  kBadInput = 1,
  kWrongUsage = 2,
  kSomeFailed = 3,
  kInterrupted = 130,
};

/// Arguments of a command, declared without the parsing library: main.cpp alone knows that.
/// Targets must outlive parsing and hold the defaults, which --help shows. After the flags may
/// stand what their value is, "--depth LEN"; else it is FILE, or N of a whole number.
class Arguments {
 public:
  virtual ~Arguments() = default;
  virtual void positional(const std::string& name, std::string& target,
                          const std::string& help) = 0;
  /// One word or more.
  virtual void positionals(const std::string& name, std::vector<std::string>& targets,
                           const std::string& help) = 0;
  virtual void option(const std::string& flags, std::string& target, const std::string& help,
                      bool is_required = false) = 0;
  virtual void option(const std::string& flags, int& target, const std::string& help) = 0;
  /// The number of threads of what does not depend on it.
  void jobs(int& target) {
    option("--jobs", target, "Number of threads; 0 uses all cores; results do not depend on it");
  }
  /// A file that the command writes. It may replace a file of these kinds only (kind_of_file).
  virtual void output(const std::string& flags, std::string& target, const std::string& help,
                      std::initializer_list<std::string_view> kinds, bool is_required = true) = 0;
  /// What the command writes besides, beside the output `target` or in the folder `target`: a file
  /// of these names that Palpate did not write is kept, unless there is --force. files: constants.
  virtual void named_outputs(const std::string& target, std::span<const NamedOutput> files) = 0;
  virtual void flag(const std::string& flags, bool& target, const std::string& help) = 0;
};

/// Output of a command on stdout: the text, or with --json one object and nothing else.
struct Reply {
  std::string text;             ///< lines for people, the last without its end; empty: none
  nlohmann::ordered_json json;  ///< an object for programs; run_program adds what all tell
};

/// A parsed command, ready to run. Every command takes --json, --quiet and --verbose.
class Command {
 public:
  virtual ~Command() = default;
  /// Fills the answer and returns an exit status.
  virtual int run(Reply& reply) = 0;
};

/// The parts between commas, without blanks at their ends.
std::vector<std::string> parts_of_list(const std::string& text);

/// Throws Error at the first of these options that is set: the command takes none of them here.
void refuse_options(std::initializer_list<std::pair<const char*, bool>> options,
                    const std::string& fact, const std::string& remedy = "Leave it out.");

/// A row of a table of commands.
struct CommandRow {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Command> (*declare)(Arguments&);
  std::string_view group = {};    ///< of the list that --help prints
  std::string_view example = {};  ///< a command line without the program's name
};
template <class SomeCommand>
std::unique_ptr<Command> declared(Arguments& arguments) {
  return std::make_unique<SomeCommand>(arguments);
}

/// Body of a `main`: parses the command line, runs the command that it names, and turns what is
/// thrown into a message and an exit status. With --json stdout is one object: "command", the
/// command's own keys, "wrote" (file, bytes), "warnings", "failures", and "errors" (where, what,
/// remedy) or "interrupted" where it did not end well.
int run_program(const char* name, const char* summary, std::span<const CommandRow> rows, int argc,
                char** argv);

extern const CommandRow kNewCommand, kCheckCommand, kRunCommand, kReportCommand, kPrepareCommand,
    kSimulateCommand, kMergeCommand, kFitCommand, kRefineCommand, kExportCommand, kValidateCommand,
    kImportCommand, kSurfaceCommand, kCalibrateCommand, kReplayCommand, kInspectCommand,
    kTabulateCommand, kStudyCommand;

}  // namespace palpate::tools
