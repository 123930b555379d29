#include "tools/workshop/rivals/node_process.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "libfit/core/error.hpp"

namespace palpate::tools {

NodeProcess::NodeProcess(const std::string& script, const std::filesystem::path& folder) {
  int in[2], out[2];
  if (::pipe(in) != 0 || ::pipe(out) != 0)
    throw Error("bench rivals", "no pipe to Node can be made", "Close other programs.");
  ::signal(SIGPIPE, SIG_IGN);
  child_ = ::fork();
  if (child_ < 0) throw Error("bench rivals", "Node cannot be started", "Close other programs.");
  if (child_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(in[0], 0);
    ::dup2(out[1], 1);
    for (const int end : {in[0], in[1], out[0], out[1]}) ::close(end);
    if (::chdir(folder.c_str()) == 0)
      ::execlp("node", "node", "--input-type=module", "-e", script.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(in[0]);
  ::close(out[1]);
  to_ = ::fdopen(in[1], "w");
  from_ = ::fdopen(out[0], "r");
}

NodeProcess::~NodeProcess() {
  if (to_ != nullptr) std::fclose(to_);
  if (from_ != nullptr) std::fclose(from_);
  ::kill(child_, SIGKILL);
  ::waitpid(child_, nullptr, 0);
}

std::string NodeProcess::ask(const std::string& line) {
  std::fputs(line.c_str(), to_);
  std::fputc('\n', to_);
  std::fflush(to_);
  char* text = nullptr;
  std::size_t room = 0;
  std::string answer;
  while (answer.empty()) {
    const ssize_t got = ::getline(&text, &room, from_);
    if (got < 0) break;
    if (got > 2 && text[0] == '=') answer.assign(text + 2, static_cast<std::size_t>(got) - 3);
  }
  std::free(text);
  return answer;
}

}  // namespace palpate::tools
