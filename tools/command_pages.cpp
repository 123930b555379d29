#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "libfit/io/atomic_file.hpp"
#include "tools/command.hpp"

namespace palpate::tools {
namespace {

struct OptionPage {
  std::string name;  ///< "--output"; of a positional "scene"
  std::string letter, help, value;
  bool is_positional = false, is_required = false;
};
struct CommandPage {
  std::string name, summary, group, example;
  std::vector<OptionPage> options;
};

CommandPage page_of(const CLI::App& command) {
  CommandPage page{command.get_name(), command.get_description(), command.get_group(), "", {}};
  const std::string footer = command.get_footer();  // "Example:\n  palpate run ..."
  if (const std::size_t at = footer.find("  "); at < footer.size())
    page.example = footer.substr(at + 2);
  for (const CLI::Option* option : command.get_options()) {
    OptionPage out;
    out.is_positional = option->get_positional();
    out.is_required = option->get_required();
    out.help = option->get_description();
    if (out.is_positional)
      out.name = option->get_name(true);
    else
      out.name = "--" + option->get_lnames().at(0);
    if (!option->get_snames().empty()) out.letter = option->get_snames()[0];
    if (!out.is_positional && option->get_items_expected_max() > 0)
      out.value = option->get_type_name();
    if (!option->get_default_str().empty())
      out.help += fmt::format(" (default: {})", option->get_default_str());
    page.options.push_back(std::move(out));
  }
  return page;
}

std::string joined(const CommandPage& page, bool is_positional) {
  std::string words;
  for (const OptionPage& option : page.options)
    if (option.is_positional == is_positional) words += (words.empty() ? "" : " ") + option.name;
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
                     const CommandPage& page) {
  std::string text = heading(program + "-" + page.name, page.summary, version);
  text += fmt::format(".B {} {}\n", program, page.name);
  for (const OptionPage& option : page.options)
    if (option.is_positional)
      text += fmt::format(".I {}\n", roff(option.name));
    else if (option.is_required)
      text += fmt::format(".B {}\n.I {}\n", roff(option.name), option.value);
  text += ".RI [ options ]\n.SH OPTIONS\n";
  for (const OptionPage& option : page.options) {
    text += ".TP\n";
    if (option.is_positional)
      text += fmt::format(".I {}\n", roff(option.name));
    else
      text +=
          fmt::format(".B {}{}{}\n", option.letter.empty() ? "" : roff("-" + option.letter + ", "),
                      roff(option.name), option.value.empty() ? "" : " " + option.value);
    text += roff(option.help) + ".\n";
  }
  if (!page.example.empty())
    text += fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n", roff(page.example));
  return text + fmt::format(".SH SEE ALSO\n.BR {} (1)\n", program);
}

std::string overview(const std::string& program, const std::string& version,
                     const std::string& summary, const std::vector<CommandPage>& pages) {
  std::string text = heading(program, summary, version);
  text += fmt::format(".B {}\n.I command\n.RI [ arguments ]\n.SH COMMANDS\n", program);
  std::string group;
  for (const CommandPage& page : pages) {
    if (page.group != group) text += fmt::format(".SS {}\n", roff(page.group));
    group = page.group;
    text += fmt::format(".TP\n.BR {}\\-{} (1)\n{}.\n", program, page.name, roff(page.summary));
  }
  text +=
      ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nbad input or surroundings; place, fact and remedy on "
      "standard error\n.TP\n2\nwrong usage\n.TP\n3\ndone, but something that was asked for failed "
      "and is listed\n.TP\n130\ninterrupted; the same command goes on from there\n"
      ".SH ENVIRONMENT\n.TP\nPALPATE_DATA\nfolder of meshes that scenes name by it\n"
      ".TP\nNO_COLOR\nset to anything, there are no colours\n";
  return text;
}

std::string bash_completion(const std::string& program, const std::vector<CommandPage>& pages) {
  std::string names, cases;
  for (const CommandPage& page : pages) {
    names += (names.empty() ? "" : " ") + page.name;
    cases += fmt::format("    {}) words='{}' ;;\n", page.name, joined(page, false));
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

std::string zsh_completion(const std::string& program, const std::vector<CommandPage>& pages) {
  std::string names, cases;
  for (const CommandPage& page : pages) {
    names += fmt::format("    '{}:{}'\n", page.name, quoted(page.summary, true));
    cases += fmt::format("    {}) _arguments", page.name);
    for (const OptionPage& option : page.options) {
      if (option.is_positional) continue;
      const std::string names_of = option.letter.empty()
                                       ? "'" + option.name
                                       : fmt::format("{{-{},{}}}'", option.letter, option.name);
      cases += fmt::format(" {}[{}]{}'", names_of, quoted(option.help, true),
                           option.value.empty() ? "" : ":value:_files");
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

std::string fish_completion(const std::string& program, const std::vector<CommandPage>& pages) {
  std::string text = "# made from the program's table of commands\n";
  for (const CommandPage& page : pages) {
    text += fmt::format("complete -c {} -n __fish_use_subcommand -f -a {} -d '{}'\n", program,
                        page.name, quoted(page.summary, false));
    for (const OptionPage& option : page.options)
      if (!option.is_positional)
        text += fmt::format(
            "complete -c {} -n '__fish_seen_subcommand_from {}' -l {}{}{} -d '{}'\n", program,
            page.name, option.name.substr(2), option.letter.empty() ? "" : " -s " + option.letter,
            option.value.empty() ? "" : " -r", quoted(option.help, false));
  }
  return text;
}

}  // namespace

void write_command_pages(const CLI::App& app, const char* version,
                         const std::filesystem::path& folder) {
  const std::string program = app.get_name();
  std::vector<CommandPage> pages;
  for (const CLI::App* command : app.get_subcommands({})) pages.push_back(page_of(*command));
  std::filesystem::create_directories(folder / "man1");
  write_file_atomically(folder / "man1" / (program + ".1"),
                        overview(program, version, app.get_description(), pages));
  for (const CommandPage& page : pages)
    write_file_atomically(folder / "man1" / fmt::format("{}-{}.1", program, page.name),
                          man_page(program, version, page));
  write_file_atomically(folder / (program + ".bash"), bash_completion(program, pages));
  write_file_atomically(folder / ("_" + program), zsh_completion(program, pages));
  write_file_atomically(folder / (program + ".fish"), fish_completion(program, pages));
}

}  // namespace palpate::tools
