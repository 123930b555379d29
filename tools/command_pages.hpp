#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace palpate::tools {

/// Writes what goes with an installed program, out of its own table of commands: man1/NAME.1 and
/// man1/NAME-COMMAND.1, and completion for bash (NAME.bash), zsh (_NAME) and fish (NAME.fish).
/// Throws Error when a file cannot be written.
void write_command_pages(const CLI::App& app, const char* version,
                         const std::filesystem::path& folder);

}  // namespace palpate::tools
