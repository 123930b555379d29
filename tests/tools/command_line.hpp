#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>

#include "tests/support/text.hpp"

namespace palpate::tools::testing_support {

namespace fs = std::filesystem;
using palpate::testing_support::holds;
using palpate::testing_support::replaced;

/// A folder of its own for one test, removed afterwards.
class Folder {
 public:
  Folder() {
    std::random_device random;
    path_ = fs::temp_directory_path() /
            ("palpate-test-" + std::to_string(random()) + std::to_string(random()));
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path operator/(const std::string& name) const { return path_ / name; }
  const fs::path& path() const { return path_; }

  fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  fs::path path_;
};

inline std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

struct Outcome {
  int status = -1;
  std::string out, err;
  std::string log = {};  ///< what a run added to its run.log

  std::string said() const { return err + log; }
};

/// Runs a line of shell in the folder and collects what it printed.
inline Outcome shell(const Folder& folder, const std::string& line) {
  const fs::path out = folder / ".stdout", err = folder / ".stderr";
  const int raw = std::system(("( cd '" + folder.path().string() + "' && " + line + " ) >" +
                               out.string() + " 2>" + err.string())
                                  .c_str());
  return {WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw), content_of(out),
          content_of(err)};
}

/// The log of a run with these arguments; empty for other commands.
inline fs::path log_of(const Folder& folder, const std::string& arguments) {
  const std::size_t at = arguments.find(" -o ");
  if (!arguments.starts_with("run ") || at == std::string::npos) return {};
  const std::string output = arguments.substr(at + 4);
  return folder / output.substr(0, output.find(' ')) / "run.log";
}

/// Runs the program in the folder with the arguments (quoted by the caller) and collects what it
/// said.
inline Outcome palpate(const Folder& folder, const std::string& arguments) {
  const fs::path log = log_of(folder, arguments);
  const std::size_t before = content_of(log).size();
  Outcome outcome = shell(folder, std::string(PALPATE_PROGRAM) + " " + arguments);
  outcome.log = content_of(log).substr(before);
  return outcome;
}

/// A square sheet of cells x cells squares as OFF; `at` writes the vertex of a column and a row.
template <class At>
std::string sheet_off(int cells, const At& at) {
  const int wide = cells + 1;
  std::ostringstream off;
  off << "OFF\n" << wide * wide << ' ' << 2 * cells * cells << " 0\n";
  for (int k = 0; k < wide * wide; ++k) at(off, k % wide, k / wide), off << '\n';
  for (int k = 0; k < cells * cells; ++k) {
    const int a = k % cells + k / cells * wide, c = a + wide;
    off << "3 " << a << ' ' << a + 1 << ' ' << c + 1 << "\n3 " << a << ' ' << c + 1 << ' ' << c
        << '\n';
  }
  return off.str();
}

}  // namespace palpate::tools::testing_support
