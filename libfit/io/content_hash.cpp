#include "libfit/io/content_hash.hpp"

#include "libfit/io/atomic_file.hpp"

namespace palpate {
namespace {

constexpr std::uint64_t kFnvPrime = 0x100000001b3u;

std::uint64_t fnv1a(std::uint64_t state, std::string_view bytes) {
  for (const char byte : bytes) state = (state ^ static_cast<unsigned char>(byte)) * kFnvPrime;
  return state;
}

std::string hex16(std::uint64_t value) {
  std::string text(16, '0');
  for (int i = 15; i >= 0; --i, value >>= 4)
    text[static_cast<std::size_t>(i)] = "0123456789abcdef"[value & 15];
  return text;
}

}  // namespace

void ContentHash::mix(std::string_view bytes) { state_ = fnv1a(state_, bytes); }

ContentHash& ContentHash::add(std::string_view bytes) {
  mix(std::to_string(bytes.size()));
  mix(":");
  mix(bytes);
  return *this;
}

ContentHash& ContentHash::add_file(const std::filesystem::path& path) {
  return add(read_whole_file(path));
}

std::string ContentHash::hex() const { return hex16(state_); }

std::string content_hash(std::string_view bytes) { return hex16(fnv1a(kFnvOffset, bytes)); }

}  // namespace palpate
