#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "libfit/recordings/batch/batch.hpp"

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

  /// The result kept under a key, if there is one; from any thread.
  std::optional<ItemResult> find(const std::string& key);
  /// Likewise under what a file looks like from outside (`stamp`, not empty), so that it need not
  /// be read to be known again.
  std::optional<ItemResult> find_stamp(const std::string& stamp);
  /// Appends; from any thread. stamp: empty where it says too little.
  void add(const std::string& key, const std::string& stamp, const ItemResult& result);
  /// Writes the journal anew with what was found or added alone, where more than half of it is
  /// something else: settings and files of before. An interruption leaves the old one.
  void compact();

 private:
  struct StoredResult {
    std::size_t offset = 0, bytes = 0;  ///< in the file
    std::string_view result;            ///< in `before_`; empty where this batch added it
    bool is_used = false;
  };
  /// The bytes of a result that is asked for, empty without one.
  std::string_view use(const std::string& key);

  std::filesystem::path path_;
  std::string before_;  ///< the file as it was
  std::unordered_map<std::string, StoredResult> kept_;
  std::unordered_map<std::string, std::string> key_of_stamp_;
  std::mutex mutex_;
  std::size_t bytes_ = 0;
  int descriptor_ = -1;
};

}  // namespace palpate::recordings
