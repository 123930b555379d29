#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

inline constexpr std::uint64_t kFnvOffset = 0xcbf29ce484222325u;  ///< of FNV-1a 64

/// A 64-bit fingerprint of what a file was made from, as 16 hex digits: equal inputs, equal hash.
/// It tells whether a result is up to date; it is no defence against forgery.
/// `add` and `add_file` include the length, so ("ab", "c") and ("a", "bc") differ.
/// Source: FNV-1a, Fowler, Noll and Vo, draft-eastlake-fnv.
class ContentHash {
 public:
  ContentHash& add(std::string_view bytes);
  /// The content of a file, not its name or date. Throws Error when it cannot be read.
  ContentHash& add_file(const std::filesystem::path& path);
  std::string hex() const;

 private:
  std::uint64_t state_ = kFnvOffset;

  void mix(std::string_view bytes);
};

/// The attribute under which a file carries the hash of what it was made from.
inline constexpr const char* kInputsAttribute = "inputs_hash";

/// Plain FNV-1a 64 of the bytes, 16 hex digits.
std::string content_hash(std::string_view bytes);

}  // namespace palpate
