#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

namespace palpate {

/// One word more into a hash. Multiplication and fold of the asset's checksum (runtime/format.hpp).
inline std::uint64_t mix_word(std::uint64_t state, std::uint64_t word) {
  state = (state ^ word) * 0x9e3779b97f4a7c15u;
  return state ^ (state >> 32);
}

/// Hash of bytes, several a nanosecond: tells content that changed by accident or by work from
/// content that did not, not an adversary's. Native byte order: for little-endian files.
inline std::uint64_t fast_hash(std::string_view bytes, std::uint64_t seed = 0) {
  std::uint64_t lane[4] = {seed, seed + 1, seed + 2, seed + 3};  // side by side in the processor
  const auto word_at = [&](std::size_t i) {
    std::uint64_t word;
    std::memcpy(&word, bytes.data() + i, sizeof word);
    return word;
  };
  std::size_t i = 0;
  for (; i + 32 <= bytes.size(); i += 32)
    for (std::size_t k = 0; k < 4; ++k) lane[k] = mix_word(lane[k], word_at(i + 8 * k));
  std::uint64_t hash = mix_word(seed, bytes.size());
  for (; i + 8 <= bytes.size(); i += 8) hash = mix_word(hash, word_at(i));
  std::uint64_t rest = 0;
  if (i < bytes.size()) std::memcpy(&rest, bytes.data() + i, bytes.size() - i);
  hash = mix_word(hash, rest);
  for (const std::uint64_t part : lane) hash = mix_word(hash, part);
  return mix_word(hash, 0);
}

/// 16 hex digits.
inline std::string hex16(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

}  // namespace palpate
