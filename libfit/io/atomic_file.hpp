#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate {

/// A file written beside its final name (NAME.partial-PID) and renamed by `commit`, so the final
/// name holds the old content or the new one, never half of it. Without `commit` (an exception,
/// an early return) the partial file is removed and the old file stays as it was.
/// A symbolic link is followed; a path that is a directory or a device is refused.
/// Throws Error when the folder is missing, cannot be written, or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  /// Name to which a library that writes by name must write, instead of `write`.
  const std::filesystem::path& partial_path() const { return partial_; }
  /// Everything is on the disk under the final name when this returns. Call it once, last.
  void commit();

 private:
  void flush();

  std::filesystem::path path_, partial_;
  std::string buffer_;
  int descriptor_ = -1;
};

/// The error of a file that the system does not write, for a reason of its own.
Error cannot_write(const std::filesystem::path& path, const std::string& reason);

/// Replaces the content of `path` by `bytes`, whole or not at all (see AtomicFile).
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// The whole content of a file. Throws Error when it is missing or cannot be read.
std::string read_whole_file(const std::filesystem::path& path);

/// A 64-bit hash of what a file was made from, as 16 hex digits: equal inputs, equal hash.
/// The end of each input counts, so ("ab", "c") and ("a", "bc") differ.
class ContentHash {
 public:
  ContentHash& add(std::string_view bytes) {
    state_ = hash_of(bytes, state_);
    return *this;
  }
  /// The content of a file, not its name or date. Throws Error when it cannot be read.
  ContentHash& add_file(const std::filesystem::path& path);
  std::string hex() const { return hex16(state_); }

 private:
  std::uint64_t state_ = 0;
};

/// The attribute under which a file carries the hash of what it was made from.
inline constexpr const char* kInputsAttribute = "inputs_hash";

}  // namespace palpate
