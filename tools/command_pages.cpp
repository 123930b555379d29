#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "libfit/io/atomic_file.hpp"
#include "tools/command.hpp"

namespace palpate::tools {
namespace {

using Commands = std::vector<const CLI::App*>;

// "--output"; of a positional "scene".
std::string name_of(const CLI::Option& option) {
  return option.get_positional() ? option.get_name(true) : "--" + option.get_lnames().at(0);
}
// Empty where it has none.
std::string letter_of(const CLI::Option& option) {
  return option.get_snames().empty() ? "" : option.get_snames()[0];
}
std::string value_of(const CLI::Option& option) {
  return option.get_items_expected_max() > 0 ? option.get_type_name() : "";
}
std::string help_of(const CLI::Option& option) {
  const std::string fallback = option.get_default_str();
  return option.get_description() +
         (fallback.empty() ? "" : fmt::format(" (default: {})", fallback));
}

// The footer is "Example:\n  palpate run ...".
std::string example_of(const CLI::App& command) {
  const std::string footer = command.get_footer();
  const std::size_t at = footer.find("  ");
  return at < footer.size() ? footer.substr(at + 2) : "";
}

std::string names_of_options(const CLI::App& command) {
  std::string words;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_positional()) words += (words.empty() ? "" : " ") + name_of(*option);
  return words;
}

// Text of a man page: no hyphenation of options, no line that begins as a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  return out;
}

std::string heading(const std::string& title, const std::string& summary,
                    const std::string& version) {
  return fmt::format(
      ".TH {} 1 \"\" \"palpate {}\" \"Palpate\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n", title,
      version, roff(title), roff(summary));
}

std::string man_page(const std::string& program, const std::string& version,
                     const CLI::App& command) {
  const std::string name = command.get_name(), example = example_of(command);
  std::string text = heading(program + "-" + name, command.get_description(), version);
  text += fmt::format(".B {} {}\n", program, name);
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional())
      text += fmt::format(".I {}\n", roff(name_of(*option)));
    else if (option->get_required())
      text += fmt::format(".B {}\n.I {}\n", roff(name_of(*option)), value_of(*option));
  text += ".RI [ options ]\n.SH OPTIONS\n";
  for (const CLI::Option* option : command.get_options()) {
    const std::string letter = letter_of(*option), value = value_of(*option);
    if (option->get_positional())
      text += fmt::format(".TP\n.I {}\n", roff(name_of(*option)));
    else
      text += fmt::format(".TP\n.B {}{}{}\n", letter.empty() ? "" : roff("-" + letter + ", "),
                          roff(name_of(*option)), value.empty() ? "" : " " + value);
    text += roff(help_of(*option)) + ".\n";
  }
  if (!example.empty()) text += fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n", roff(example));
  return text + fmt::format(".SH SEE ALSO\n.BR {} (1)\n", program);
}

std::string overview(const std::string& program, const std::string& version,
                     const std::string& summary, const Commands& commands) {
  std::string text = heading(program, summary, version);
  text += fmt::format(".B {}\n.I command\n.RI [ arguments ]\n.SH COMMANDS\n", program);
  std::string group;
  for (const CLI::App* command : commands) {
    if (command->get_group() != group) text += fmt::format(".SS {}\n", roff(command->get_group()));
    group = command->get_group();
    text += fmt::format(".TP\n.BR {}\\-{} (1)\n{}.\n", program, command->get_name(),
                        roff(command->get_description()));
  }
  text +=
      ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nbad input or surroundings; place, fact and remedy on "
      "standard error\n.TP\n2\nwrong usage\n.TP\n3\ndone, but something that was asked for failed "
      "and is listed\n.TP\n130\ninterrupted; the same command goes on from there\n"
      ".SH ENVIRONMENT\n.TP\nPALPATE_DATA\nfolder of meshes that scenes name by it\n"
      ".TP\nNO_COLOR\nset to anything, there are no colours\n";
  return text;
}

std::string bash_completion(const std::string& program, const Commands& commands) {
  std::string names, cases;
  for (const CLI::App* command : commands) {
    names += (names.empty() ? "" : " ") + command->get_name();
    cases +=
        fmt::format("    {}) words='{}' ;;\n", command->get_name(), names_of_options(*command));
  }
  return fmt::format(
      "# bash completion for {0}, made from its table of commands\n"
      "_{0}() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} words=\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W '{1}' -- \"$current\")\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n{2}  esac\n"
      "  if [[ $current == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
      "  fi\n"
      "}}\n"
      "complete -o default -F _{0} {0}\n",
      program, names, cases);
}

// Within single quotes of zsh and fish; zsh takes brackets and colons for its own.
std::string quoted(const std::string& text, bool is_zsh) {
  std::string out;
  for (const char c : text) {
    if (is_zsh && (c == '[' || c == ']' || c == ':')) out += '\\';
    out += c == '\'' ? (is_zsh ? "'\\''" : "\\'") : std::string(1, c);
  }
  return out;
}

std::string zsh_completion(const std::string& program, const Commands& commands) {
  std::string names, cases;
  for (const CLI::App* command : commands) {
    names +=
        fmt::format("    '{}:{}'\n", command->get_name(), quoted(command->get_description(), true));
    cases += fmt::format("    {}) _arguments", command->get_name());
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_positional()) continue;
      const std::string name = name_of(*option), letter = letter_of(*option);
      const std::string names_of =
          letter.empty() ? "'" + name : fmt::format("{{-{},{}}}'", letter, name);
      cases += fmt::format(" {}[{}]{}'", names_of, quoted(help_of(*option), true),
                           value_of(*option).empty() ? "" : ":value:_files");
    }
    cases += " '*:file:_files' ;;\n";
  }
  return fmt::format(
      "#compdef {0}\n# made from the program's table of commands\n"
      "_{0}() {{\n"
      "  local -a commands=(\n{1}  )\n"
      "  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n  (( CURRENT-- ))\n"
      "  case $command in\n{2}  esac\n"
      "}}\n"
      "_{0} \"$@\"\n",
      program, names, cases);
}

std::string fish_completion(const std::string& program, const Commands& commands) {
  std::string text = "# made from the program's table of commands\n";
  for (const CLI::App* command : commands) {
    text += fmt::format("complete -c {} -n __fish_use_subcommand -f -a {} -d '{}'\n", program,
                        command->get_name(), quoted(command->get_description(), false));
    for (const CLI::Option* option : command->get_options())
      if (!option->get_positional())
        text +=
            fmt::format("complete -c {} -n '__fish_seen_subcommand_from {}' -l {}{}{} -d '{}'\n",
                        program, command->get_name(), name_of(*option).substr(2),
                        letter_of(*option).empty() ? "" : " -s " + letter_of(*option),
                        value_of(*option).empty() ? "" : " -r", quoted(help_of(*option), false));
  }
  return text;
}

}  // namespace

void write_command_pages(const CLI::App& app, const char* version,
                         const std::filesystem::path& folder) {
  const std::string program = app.get_name();
  const Commands commands = app.get_subcommands([](const CLI::App*) { return true; });
  std::filesystem::create_directories(folder / "man1");
  write_file_atomically(folder / "man1" / (program + ".1"),
                        overview(program, version, app.get_description(), commands));
  for (const CLI::App* command : commands)
    write_file_atomically(folder / "man1" / fmt::format("{}-{}.1", program, command->get_name()),
                          man_page(program, version, *command));
  write_file_atomically(folder / (program + ".bash"), bash_completion(program, commands));
  write_file_atomically(folder / ("_" + program), zsh_completion(program, commands));
  write_file_atomically(folder / (program + ".fish"), fish_completion(program, commands));
}

}  // namespace palpate::tools
