// palpate_make_bodies [--check] DIR: writes the shipped bodies into DIR, or compares DIR with them.

#include <fmt/core.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "data/generators/bodies.hpp"
#include "libfit/core/error.hpp"

namespace palpate::bodies {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path partial = file.string() + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream)
    throw Error(partial.string(), "cannot be written", "Make the folder, or name another.");
  std::filesystem::rename(partial, file);
}

void compare(const std::filesystem::path& file, const std::string& text) {
  std::ifstream stream(file, std::ios::binary);
  const std::string there{std::istreambuf_iterator<char>(stream), {}};
  if (there != text)
    throw Error(
        file.string(), "is not what its generator makes",
        "Run palpate_make_bodies on that folder and commit the difference, with its reason.");
}

void print(const char* file, const Surface& body, const BodyFacts& facts) {
  fmt::print(
      "{}: {:.1f} x {:.1f} x {:.1f} mm, {:.1f} ml, {:.1f} cm2, {} vertices, {} triangles, "
      "mean edge {:.2f} mm, smallest angle {:.1f} degrees, sharpest fold {:.1f} degrees\n",
      file, facts.extent_mm[0], facts.extent_mm[1], facts.extent_mm[2], facts.volume_ml,
      facts.area_cm2, body.vertices.rows(), body.triangles.rows(), facts.mean_edge_mm,
      facts.smallest_angle_deg, facts.sharpest_fold_deg);
}

void make(const NamedBody& named, const std::filesystem::path& folder, bool is_check) {
  const Surface body = rounded(named.make_mm());
  print(named.file, body, inspect(named.file, body));
  const std::string text =
      obj_text(fmt::format("{}, in mm, made by palpate_make_bodies", named.file), body);
  if (is_check)
    compare(folder / named.file, text);
  else
    write(folder / named.file, text);
}

// Each body in a process of its own: the mesher's choices depend on what memory it is given.
bool make_all(const std::filesystem::path& folder, bool is_check) {
  bool is_good = true;
  for (const NamedBody& named : kBodies) {
    const pid_t child = ::fork();
    if (child == 0) {
      int code = 0;
      try {
        make(named, folder, is_check);
      } catch (const std::exception& error) {
        fmt::print(stderr, "palpate: error: {}\n", error.what());
        code = 1;
      }
      std::fflush(nullptr);
      ::_exit(code);
    }
    int status = 0;
    is_good &= child > 0 && ::waitpid(child, &status, 0) == child && status == 0;
  }
  return is_good;
}

}  // namespace
}  // namespace palpate::bodies

int main(int count, char** arguments) {
  const bool is_check = count == 3 && std::string(arguments[1]) == "--check";
  if (!is_check && count != 2) {
    fmt::print(stderr, "usage: palpate_make_bodies [--check] DIR\n");
    return 2;
  }
  return palpate::bodies::make_all(arguments[count - 1], is_check) ? 0 : 1;
}
