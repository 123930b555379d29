#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

/// 64-bit hash of bytes: tells content that changed from content that did not. It is no defence
/// against forgery. A hash given as `seed` makes a chain: the result depends on all links and on
/// where each ends. Source: XXH3 of libxxhash, Collet 2020.
std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed = 0);

/// 16 hex digits.
std::string hex16(std::uint64_t hash);

}  // namespace palpate
