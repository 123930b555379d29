#include "libfit/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace palpate {
namespace fs = std::filesystem;

Error cannot_write(const fs::path& path, const std::string& reason) {
  return Error(path.string(), "cannot be written: " + reason,
               "Choose a folder that exists, can be written and has space.");
}

namespace {

// The file that a rename must replace: the target of a link, not the link.
fs::path final_path(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) throw cannot_write(path, "it is a folder");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw cannot_write(path, "it is not a regular file");
  if (!fs::is_symlink(fs::symlink_status(path, ignored))) return path;
  const fs::path target = fs::weakly_canonical(path, ignored);
  return ignored ? path : target;
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& path) : path_(final_path(path)) {
  partial_ = path_;
  partial_ += fmt::format(".partial-{}", ::getpid());
  descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw cannot_write(path_, std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  std::error_code ignored;
  if (!partial_.empty()) fs::remove(partial_, ignored);
}

void AtomicFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= 1 << 20) flush();  // one system call per MiB of a long table
}

void AtomicFile::flush() {
  assert(descriptor_ >= 0);
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(path_, std::strerror(errno));
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void AtomicFile::commit() {
  flush();
  const bool is_stored = ::fsync(descriptor_) == 0;
  const int reason = errno;
  const bool is_closed = ::close(descriptor_) == 0;
  descriptor_ = -1;
  if (!is_stored) throw cannot_write(path_, std::strerror(reason));
  if (!is_closed) throw cannot_write(path_, std::strerror(errno));
  if (::rename(partial_.c_str(), path_.c_str()) != 0)
    throw cannot_write(path_, std::strerror(errno));
  partial_.clear();
}

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::string read_whole_file(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) throw Error(path.string(), "no such file", "Check the name.");
  if (fs::is_directory(status)) throw Error(path.string(), "is a folder", "Name a file in it.");
  if (!fs::is_regular_file(status))  // a pipe without a writer never ends, a device may not either
    throw Error(path.string(), "is no regular file",
                "Write what the pipe or device holds to a file, and name that.");
  std::ifstream file(path, std::ios::binary);
  std::string bytes;
  const std::uintmax_t known = fs::file_size(path, ignored);
  if (!ignored) bytes.reserve(known);
  std::string part(1 << 16, '\0');  // stays in the processor's cache
  while (file.good()) {
    file.read(part.data(), static_cast<std::streamsize>(part.size()));
    bytes.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad())
    throw Error(path.string(), "cannot be read", "Check its permissions.");
  return bytes;
}

ContentHash& ContentHash::add_file(const fs::path& path) { return add(read_whole_file(path)); }

}  // namespace palpate
