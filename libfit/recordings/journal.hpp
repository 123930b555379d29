#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <unordered_map>

#include "libfit/recordings/batch.hpp"

namespace palpate::recordings {

/// Results of a batch on the disk, an entry appended as each is done. Every entry carries its
/// length and hash: what a kill cut short, or a disk damaged, is left out on reading, and the rest
/// is good. Safe on untrusted bytes.
class Journal {
 public:
  /// Reads what is there. An empty path keeps nothing. Throws Error when the file cannot be
  /// written.
  explicit Journal(const std::filesystem::path& path);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// The result kept under a key; nullptr when there is none.
  const ItemResult* find(const std::string& key) const;
  /// Appends; from any thread.
  void add(const std::string& key, const ItemResult& result);

 private:
  std::unordered_map<std::string, ItemResult> kept_;
  std::mutex mutex_;
  int descriptor_ = -1;
};

}  // namespace palpate::recordings
