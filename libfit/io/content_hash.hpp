#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "libfit/core/text.hpp"

namespace palpate {

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
