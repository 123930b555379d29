#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>
#include <vector>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {

/// Starts the program with these arguments, sends it the signal once `has_begun`, or after a
/// minute, and returns what waitpid says of its end. log: where both its streams go.
template <class HasBegun>
int stopped(int signal, std::vector<std::string> words, const HasBegun& has_begun,
            const fs::path& log = {}) {
  words.insert(words.begin(), "palpate");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (!log.empty()) {
      const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(file, STDOUT_FILENO), dup2(file, STDERR_FILENO);
    }
    execv(PALPATE_PROGRAM, arguments.data());
    _exit(127);
  }
  for (int wait_ms = 0; wait_ms < 60000 && !has_begun(); ++wait_ms)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, signal);
  int raw = 0;
  waitpid(child, &raw, 0);
  return raw;
}

/// The exit status that is meant by it; -1 of a signal.
inline int exit_status(int raw) { return WIFEXITED(raw) ? WEXITSTATUS(raw) : -1; }

}  // namespace palpate::tools::testing_support
