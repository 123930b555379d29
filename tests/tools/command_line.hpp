#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>

namespace palpate::tools::testing_support {

namespace fs = std::filesystem;

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

/// Runs a line of shell and collects what it printed.
inline Outcome shell(const Folder& folder, const std::string& line) {
  const fs::path out = folder / ".stdout", err = folder / ".stderr";
  const int raw = std::system(("( " + line + " ) >" + out.string() + " 2>" + err.string()).c_str());
  return {WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw), content_of(out),
          content_of(err)};
}

/// The log of a run with these arguments; empty for other commands.
inline fs::path log_of(const std::string& arguments) {
  const std::size_t at = arguments.find(" -o ");
  if (!arguments.starts_with("run ") || at == std::string::npos) return {};
  const std::string folder = arguments.substr(at + 4);
  return fs::path(folder.substr(0, folder.find(' '))) / "run.log";
}

/// Runs the program with the arguments (quoted by the caller) and collects what it said.
inline Outcome palpate(const Folder& folder, const std::string& arguments) {
  const fs::path log = log_of(arguments);
  const std::size_t before = content_of(log).size();
  Outcome outcome = shell(folder, std::string(PALPATE_PROGRAM) + " " + arguments);
  outcome.log = content_of(log).substr(before);
  return outcome;
}

/// The same in the folder, so that names are as the user gives them. to: where stdout goes.
inline Outcome palpate_in(const Folder& folder, const std::string& arguments,
                          const std::string& to = "") {
  return shell(folder, "cd '" + folder.path().string() + "' && " + std::string(PALPATE_PROGRAM) +
                           " " + arguments + " " + to);
}

/// A box [0, size] mm of 12 triangles as OFF.
inline std::string box_off(double x, double y, double z) {
  std::string text = "OFF\n8 12 0\n";
  for (int i = 0; i < 8; ++i)
    text += std::to_string(i & 1 ? x : 0) + " " + std::to_string(i & 2 ? y : 0) + " " +
            std::to_string(i & 4 ? z : 0) + "\n";
  return text +
         "3 0 2 3\n3 0 3 1\n3 4 5 7\n3 4 7 6\n3 0 1 5\n3 0 5 4\n3 2 6 7\n3 2 7 3\n3 0 4 6\n3 0 6 "
         "2\n3 1 3 7\n3 1 7 5\n";
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
