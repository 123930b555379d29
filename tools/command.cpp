#include "tools/command.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>

#include "libfit/core/error.hpp"
#include "libfit/core/same_bytes.hpp"
#include "tools/build_identity.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/nearest_name.hpp"

namespace palpate::tools {
namespace {

// Options of every command.
struct OutputFlags {
  bool json = false, quiet = false, verbose = false;
};

// What is wrong with the name of an output; nothing where it is one. CLI11 takes -o=a for "=a".
std::string fault_of_output(const std::string& typed) {
  if (typed.empty()) return "is an empty name";
  return typed.starts_with('=') ? "begins with =: leave a blank before the name" : "";
}

// Declares a command's options on a CLI11 subcommand.
class CliArguments final : public Arguments {
 public:
  explicit CliArguments(CLI::App& app) : app_(app) {}
  void positional(const std::string& name, std::string& target, const std::string& help) override {
    app_.add_option(name, target, help)->required()->type_name("");
    texts_.push_back(&target);
  }
  void positionals(const std::string& name, std::vector<std::string>& targets,
                   const std::string& help) override {
    app_.add_option(name, targets, help)->required()->type_name("");
  }
  void option(const std::string& flags, std::string& target, const std::string& help,
              bool is_required) override {
    auto* option = add(flags, target, help, "FILE");
    if (is_required) option->required();
    if (!target.empty()) option->capture_default_str();
    if (flags.starts_with("-o")) option->check(fault_of_output);
    (flags.starts_with("-o") ? folders_ : texts_).push_back(&target);
  }
  void output(const std::string& flags, std::string& target, const std::string& help,
              std::initializer_list<std::string_view> kinds, bool is_required) override {
    auto* option = add(flags, target, help, "FILE")->check(fault_of_output);
    if (is_required) option->required();
    outputs_.push_back({&target, kinds});
  }
  void named_outputs(const std::string& target, std::span<const NamedOutput> files) override {
    named_outputs_.push_back({&target, files});
  }
  void option(const std::string& flags, int& target, const std::string& help) override {
    add(flags, target, help, "N")
        ->capture_default_str()
        ->check([](const std::string& typed) {  // CLI11 takes an empty word for 0
          return std::string(typed.empty() ? "is no whole number" : "");
        });
  }
  void flag(const std::string& flags, bool& target, const std::string& help) override {
    app_.add_flag(flags, target, help);
  }
  void add_output_flags() {
    const auto add = [&](const char* names, bool& target, const char* help) {
      return app_.add_flag(names, target, help)->group("Output");
    };
    add("--json", flags_.json, "Print one JSON object on stdout and nothing else there");
    auto* quiet = add("--quiet", flags_.quiet, "Say errors and failed items alone");
    add("-v,--verbose", flags_.verbose, "Say with each line when it was")->excludes(quiet);
  }
  const OutputFlags& output_flags() const { return flags_; }
  std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const OutputFile& file : outputs_) names.push_back(*file.target);
    return names;
  }
  bool is_parsed() const { return app_.parsed(); }

  /// The nearest option where the command has none of this name; nothing where it has.
  std::optional<std::string> unknown_option(std::string_view typed) const {
    std::vector<std::string> known;
    for (const CLI::Option* option : app_.get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    if (std::find(known.begin(), known.end(), typed) != known.end()) return std::nullopt;
    return nearest_name(typed, {known.begin(), known.end()});
  }

  void check_outputs() const {
    std::vector<std::string> inputs;
    for (const std::string* text : texts_) inputs.push_back(*text);
    for (const std::string* folder : folders_) refuse_stdout(*folder);
    for (const auto& [target, kinds] : outputs_)
      if (!target->empty()) check_output(*target, kinds, inputs);
    const CLI::Option* force = app_.get_option_no_throw("--force");
    if (force && !force->empty()) return;
    for (const auto& [target, files] : named_outputs_)
      if (!target->empty()) check_named_outputs(*target, files, force != nullptr);
  }

 private:
  template <class T>
  CLI::Option* add(const std::string& flags, T& target, const std::string& help,
                   const char* value) {
    const std::size_t blank = flags.find(' ');
    return app_.add_option(flags.substr(0, blank), target, help)
        ->type_name(blank < flags.size() ? flags.substr(blank + 1) : value);
  }
  struct OutputFile {
    const std::string* target;
    std::vector<std::string_view> kinds;
  };
  struct FilesOfOutput {
    const std::string* target;
    std::span<const NamedOutput> files;
  };

  CLI::App& app_;
  std::vector<const std::string*> texts_, folders_;  // what is given, and folders to write
  std::vector<OutputFile> outputs_;
  std::vector<FilesOfOutput> named_outputs_;
  OutputFlags flags_;
};

struct DeclaredCommand {
  std::unique_ptr<CliArguments> arguments;
  std::unique_ptr<Command> command;
};

// Keeps stdout for the answer: until `say` whatever is printed there, by whomever, goes to stderr
// with --json and nowhere with --quiet.
class Stdout {
 public:
  void set_aside(const OutputFlags& flags) {
    if (!flags.json && !flags.quiet) return;
    kept_ = ::dup(STDOUT_FILENO);
    const int instead = flags.quiet ? ::open("/dev/null", O_WRONLY) : ::dup(STDERR_FILENO);
    ::dup2(instead, STDOUT_FILENO);
    ::close(instead);
  }
  /// Throws Error where not all that was printed has been written.
  void say(const std::string& text) {
    std::fflush(stdout);
    if (kept_ >= 0) ::dup2(kept_, STDOUT_FILENO), std::clearerr(stdout);
    if (!text.empty()) std::fprintf(stdout, "%s\n", text.c_str());
    const int reason = std::fflush(stdout) != 0 ? errno : EIO;
    if (std::ferror(stdout) != 0)
      throw Error("stdout", fmt::format("cannot be written: {}", std::strerror(reason)),
                  "Send it to a place that has space and can be written.");
  }

 private:
  int kept_ = -1;
};

// A command while it runs, and what it says on stdout when it has ended.
class Session {
 public:
  int run(const std::string& name, const DeclaredCommand& declared) {
    command_ = name;
    flags_ = declared.arguments->output_flags();
    set_loudness(flags_.quiet     ? Loudness::quiet
                 : flags_.verbose ? Loudness::verbose
                                  : Loudness::normal);
    out_.set_aside(flags_);
    declared.arguments->check_outputs();
    const int status = declared.command->run(reply_);
    if (status != kBadInput) wrote_ = declared.arguments->outputs();
    return status;
  }
  /// Throws Error where stdout cannot be written.
  void say_answer() {
    if (flags_.json)
      say_object(nullptr);
    else
      out_.say(flags_.quiet ? "" : reply_.text);
  }
  /// ended: "errors" or "interrupted". What cannot be written is lost: stderr has it already.
  void say_end(const nlohmann::ordered_json& ended) {
    if (!flags_.json) return;  // or the command line was not understood
    try {
      say_object(ended);
    } catch (const Error&) {
    }
  }
  /// A command line that was not understood: whether it asks for --json, and of which command.
  void set_words(std::span<char*> words, const std::string& command) {
    flags_.json =
        std::ranges::any_of(words, [](std::string_view word) { return word == "--json"; });
    command_ = command;
  }
  /// Answer to --help and --version.
  void answer(std::string text) { reply_.text = std::move(text); }

 private:
  void say_object(const nlohmann::ordered_json& ended) {
    out_.say(object(ended).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  nlohmann::ordered_json object(const nlohmann::ordered_json& ended) const {
    nlohmann::ordered_json object{{"command", command_}};
    if (!reply_.json.is_null()) object.update(reply_.json);
    for (const std::string& file : wrote_)
      if (std::error_code missing; !file.empty() && std::filesystem::is_regular_file(file, missing))
        object["wrote"].push_back(
            {{"file", file}, {"bytes", std::filesystem::file_size(file, missing)}});
    for (const auto& [key, tone] :
         {std::pair{"warnings", Tone::warning}, {"failures", Tone::failed}})
      if (!said(tone).empty() && !object.contains(key)) object[key] = said(tone);
    if (!ended.is_null()) object.update(ended);
    return object;
  }

  std::string command_;
  OutputFlags flags_;
  Stdout out_;
  Reply reply_;
  std::vector<std::string> wrote_;
};

// "palpate run"; command: empty where it is not known.
std::string program_of(const CLI::App& app, const std::string& command) {
  return app.get_name() + (command.empty() ? "" : " " + command);
}

// A command line that is not understood. hint: a sentence and a space, or nothing.
struct WrongUsage : Error {
  WrongUsage(const CLI::App& app, const std::string& of, const std::string& what,
             const std::string& hint = "")
      : Error(program_of(app, of), what,
              fmt::format("{}See {} --help.", hint, program_of(app, of))),
        command(of) {}
  std::string command, help;  // help: for stderr alone
};

// Refuses a first word that is no command, and an option none of the command's; says what was
// meant. CLI11 would complain of what is missing instead.
void refuse_misspelt(const CLI::App& app, std::span<const CommandRow> rows,
                     const std::map<std::string, DeclaredCommand>& declared,
                     std::span<char*> words) {
  if (words.empty()) {
    WrongUsage wrong(app, "", "no command is given");
    wrong.help = "\n" + app.help();
    throw wrong;
  }
  if (words[0][0] == '-') return;
  const auto refuse = [&](const std::string& command, const std::string& what,
                          const std::string& nearest) {
    throw WrongUsage(app, command, what,
                     nearest.empty() ? "" : fmt::format("Did you mean \"{}\"? ", nearest));
  };
  const auto found = declared.find(words[0]);
  if (found == declared.end()) {
    std::vector<std::string_view> names;
    for (const CommandRow& row : rows) names.push_back(row.name);
    refuse("", fmt::format("there is no command \"{}\"", words[0]), nearest_name(words[0], names));
  }
  for (const std::string_view word : words.subspan(1)) {
    if (word == "--") break;
    if (!word.starts_with("--")) continue;
    const std::string_view name = word.substr(0, word.find('='));
    if (const auto nearest = found->second.arguments->unknown_option(name))
      refuse(words[0], fmt::format("there is no option {}", name), *nearest);
  }
}

int run_command(CLI::App& app, std::span<const CommandRow> rows, int argc, char** argv,
                Session& session) {
  app.require_subcommand(1);
  app.footer(fmt::format("See {} help COMMAND.", app.get_name()));
  app.set_version_flag("-V,--version", "palpate " PALPATE_VERSION);
  std::map<std::string, DeclaredCommand> declared;
  for (const CommandRow& row : rows) {
    CLI::App* const command_app =
        app.add_subcommand(std::string(row.name), std::string(row.summary));
    if (!row.group.empty()) command_app->group(std::string(row.group));
    if (!row.example.empty())
      command_app->footer(fmt::format("Example:\n  {} {}", app.get_name(), row.example));
    auto arguments = std::make_unique<CliArguments>(*command_app);
    auto command = row.declare(*arguments);
    arguments->add_output_flags();
    declared[std::string(row.name)] = {std::move(arguments), std::move(command)};
  }
  std::vector<char*> words(argv, argv + argc);
  std::string help = "--help";
  if (words.size() > 1 && words[1] == std::string_view("help")) {  // help COMMAND
    words.erase(words.begin() + 1);
    words.push_back(help.data());
  }
  refuse_misspelt(app, rows, declared, std::span(words).subspan(1));
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& e) {
    // CLI11 has exit codes of its own (105-110); ours are a contract.
    if (e.get_exit_code() == 0) {  // --help, --version
      std::ostringstream text;
      app.exit(e, text, text);
      std::string answer = text.str();
      if (answer.ends_with('\n')) answer.pop_back();
      session.answer(std::move(answer));
      return kDone;
    }
    const auto parsed = std::find_if(declared.begin(), declared.end(), [](const auto& row) {
      return row.second.arguments->is_parsed();
    });
    const bool is_no_number = dynamic_cast<const CLI::ConversionError*>(&e) != nullptr;
    std::string what = e.what();  // "Could not convert: --jobs = many"
    if (is_no_number) what = what.substr(what.find(": ") + 2) + " is no whole number";
    throw WrongUsage(app, parsed == declared.end() ? "" : parsed->first, what);
  }
  for (const auto& [name, row] : declared)
    if (row.arguments->is_parsed()) return session.run(name, row);
  return kWrongUsage;
}

// Says it on stderr and, with --json, as "errors" on stdout.
int refuse(Session& session, const Error& error, ExitStatus status = kBadInput) {
  to_stderr("palpate: error: {}\n", error.what());
  session.say_end(
      {{"errors",
        {{{"where", error.where()}, {"what", error.fact()}, {"remedy", error.remedy()}}}}});
  return status;
}

}  // namespace

std::vector<std::string> parts_of_list(const std::string& text) {
  auto parts = text.empty() ? std::vector<std::string>() : CLI::detail::split(text, ',');
  for (std::string& part : parts) CLI::detail::trim(part);
  return parts;
}

void refuse_options(std::initializer_list<std::pair<const char*, bool>> options,
                    const std::string& fact, const std::string& remedy) {
  for (const auto& [option, is_set] : options)
    if (is_set) throw Error(option, fact, remedy);
}

int run_program(const char* name, const char* summary, std::span<const CommandRow> rows, int argc,
                char** argv) {
  // One that is closed would become the next file that is opened, and get what is printed.
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(standard, F_GETFD) < 0) ::open("/dev/null", O_RDONLY);
  catch_interrupts();
  fix_order_of_sums();
  Session session;
  try {
    CLI::App app(summary, name);
    const int status = run_command(app, rows, argc, argv, session);
    session.say_answer();
    return status;
  } catch (const Interrupted& e) {
    to_stderr("palpate: interrupted: {}\n", e.what());
    session.say_end({{"interrupted", e.what()}});
    if (has_abandoned_work()) {
      std::fflush(nullptr);
      std::_Exit(kInterrupted);
    }
    return kInterrupted;
  } catch (const WrongUsage& e) {
    session.set_words({argv, argv + argc}, e.command);
    const int status = refuse(session, e, kWrongUsage);
    to_stderr("{}", e.help);
    return status;
  } catch (const Error& e) {
    return refuse(session, e);
  } catch (const std::bad_alloc&) {
    return refuse(session, {"memory", "there is not enough of it",
                            "Use fewer --jobs or a coarser mesh, or raise the limit (ulimit -v)."});
  } catch (const std::filesystem::filesystem_error& e) {
    return refuse(session, {e.path1().string(), e.code().message(),
                            "Check the name, the permissions and the space."});
  } catch (const std::system_error& e) {
    return refuse(session,
                  {"system", e.what(),
                   "Use fewer --jobs, or raise the limits of memory and threads (ulimit -v, -u)."});
  } catch (const std::exception& e) {
    return refuse(session,
                  {"internal", e.what(), "Please report this with the command that caused it."});
  }
}

}  // namespace palpate::tools
