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
}

}  // namespace palpate::tools
