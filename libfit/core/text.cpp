#include "libfit/core/text.hpp"

#include <fmt/format.h>
#include <xxhash.h>
#include <array>
#include <charconv>

namespace palpate {

std::string number(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

std::string percent(double share, int decimals) {
  return fmt::format("{:.{}f} %", 100 * share, decimals);
}

std::string millimetres(double length_m) { return number(1e3 * length_m) + " mm"; }

std::string counted(std::int64_t count, std::string_view one, std::string_view several) {
  return fmt::format("{} {}", count, count == 1 ? one : several);
}

std::string coordinates(const Vec3& point_m) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", point_m.x(), point_m.y(), point_m.z());
}

std::string file_line(std::string_view file, std::size_t line) {
  return fmt::format("{}:{}", file, line);
}

std::string listed(std::span<const std::string> texts, std::string_view separator) {
  return fmt::format("{}", fmt::join(texts, separator));
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

void add_sentence(std::string& message, std::string_view sentence) {
  message.append(message.empty() ? "" : "; ").append(sentence);
}

std::string to_text(double value) {
  std::array<char, 32> digits;  // the longest double takes 24
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::string hex16(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

}  // namespace palpate
