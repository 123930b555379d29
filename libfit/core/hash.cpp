#include "libfit/core/hash.hpp"

#include <fmt/format.h>
#include <xxhash.h>

namespace palpate {

std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::string hex16(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

}  // namespace palpate
