#include "tools/outputs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate::tools {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view kHdf5Magic = "\x89HDF";
constexpr std::string_view kDamagedHdf5 = "damaged HDF5";
constexpr std::string_view kNamed[] = {"palp", "HDF5", kDamagedHdf5};

bool can_be_opened(const fs::path& hdf5) {
  try {
    h5::Reader(hdf5, "");
    return true;
  } catch (const Error&) {
    return false;
  }
}

std::string in_words(const std::string& kind) {
  const bool is_named =
      kind.starts_with("palpate-") || std::ranges::find(kNamed, kind) != std::end(kNamed);
  return is_named ? "holds " + kind : fmt::format("begins with \"{}\"", kind.substr(0, 30));
}

// The folder itself or the nearest one above it that exists.
fs::path existing(fs::path path) {
  path = fs::absolute(path).lexically_normal();
  std::error_code ignored;
  while (!fs::exists(path, ignored) && path.has_relative_path()) path = path.parent_path();
  return path;
}

// A file system without locks (some network ones) lets everyone in.
bool is_locked_by_another(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

}  // namespace

std::string kind_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(4096, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(file.gcount());
  if (bytes.starts_with(kHdf5Magic)) {
    try {
      return schema_of(path);
    } catch (const Error&) {
      return can_be_opened(path) ? "HDF5" : std::string(kDamagedHdf5);
    }
  }
  if (bytes.starts_with("PALP")) return "palp";
  if (bytes.starts_with("{")) {  // and the keys that follow, however they are laid out
    std::erase_if(bytes, [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; });
    return bytes;
  }
  return bytes.substr(0, bytes.find_first_of("\r\n"));
}

void refuse_stdout(const std::string& output) {
  if (output == "-")
    throw Error("-", "is no file, and nothing is written to stdout but answers",
                "Give the output a name; --json prints the answer on stdout.");
}

void check_output(const fs::path& output, std::span<const std::string_view> kinds,
                  std::span<const std::string> inputs) {
  refuse_stdout(output.string());
  std::error_code ignored;
  if (!fs::is_regular_file(output, ignored) || fs::is_empty(output, ignored)) return;
  const std::string found = kind_of_file(output);
  const auto is_of = [&](std::string_view kind) { return found.starts_with(kind); };
  if (std::any_of(kinds.begin(), kinds.end(), is_of)) return;
  const auto is_output = [&](const std::string& input) {
    return fs::equivalent(input, output, ignored);
  };
  const bool is_input = std::any_of(inputs.begin(), inputs.end(), is_output);
  throw Error(
      output.string(),
      is_input        ? "is also an input of this command, which would replace it"
      : kinds.empty() ? "is there already, and this command replaces no file"
                      : in_words(found) + ", which this command does not write",
      "Give the output another name" + std::string(is_input ? "." : ", or remove the file first."));
}

void check_named_outputs(const fs::path& target, std::span<const NamedOutput> files,
                         bool can_force) {
  for (const auto& [name, kind] : files) {
    fs::path file = target;
    if (name.starts_with('.') && !name.starts_with(".."))
      file.replace_extension(name);
    else
      file = (file / name).lexically_normal();
    std::error_code ignored;
    if (!fs::exists(file, ignored) || fs::is_empty(file, ignored)) continue;
    const std::string found = kind_of_file(file);
    // A file of ours that was cut short is made again.
    if (found.starts_with(kind) || (found == kDamagedHdf5 && kind.starts_with("palpate-")))
      continue;
    throw Error(file.string(), in_words(found) + ", and Palpate did not write it",
                can_force ? "Move it away, choose another output, or let --force replace it."
                          : "Move it away, or choose another output.");
  }
}

OutputLock::OutputLock(const fs::path& output) : path_(output.string() + ".lock") {
  // Until what is locked is what the name says: a writer that ends removes it.
  for (struct stat locked{}, named{}; descriptor_ < 0;) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw Error(output.string(), fmt::format("cannot be written: {}", std::strerror(errno)),
                  "Choose a folder that exists, can be written and has space.");
    if (is_locked_by_another(descriptor_)) {
      ::close(descriptor_);
      throw Error(output.string(), "another palpate is writing this file",
                  "Wait for it to end, or choose another name.");
    }
    if (::fstat(descriptor_, &locked) == 0 && ::stat(path_.c_str(), &named) == 0 &&
        locked.st_ino == named.st_ino)
      break;
    ::close(std::exchange(descriptor_, -1));
  }
}

OutputLock::~OutputLock() {
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

OutputFolder::OutputFolder(fs::path path) : path_(std::move(path)) {
  const fs::path found = existing(path_);
  if (!fs::is_directory(found))
    throw Error(found.string(), "is a file, so no folder can be made there",
                "Give -o the name of a folder.");
  if (::access(found.c_str(), W_OK | X_OK) != 0)
    throw Error(found.string(), fmt::format("cannot be written: {}", std::strerror(errno)),
                "Choose a folder that can be written.");
}

OutputFolder::~OutputFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFolder::claim() {
  if (descriptor_ >= 0) return;
  std::error_code failure;
  fs::create_directories(path_, failure);
  if (!failure) descriptor_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw Error(path_.string(),
                "cannot be made: " + (failure ? failure.message() : std::strerror(errno)),
                "Choose a folder that can be written.");
  if (is_locked_by_another(descriptor_))
    throw Error(path_.string(), "another palpate is writing into this folder",
                "Wait for it to end, or choose another folder.");
}

}  // namespace palpate::tools
