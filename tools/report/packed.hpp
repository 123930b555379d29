#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools {

using Json = nlohmann::ordered_json;

/// Bytes as text (RFC 4648, section 4).
inline std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

/// The bytes again; anything after the first character of no digit is left out.
inline std::string from_base64(std::string_view text) {
  const auto digit = [](char c) -> int {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  };
  std::string out;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    const int value = digit(c);
    if (value < 0) break;
    group = group << 6 | static_cast<std::uint32_t>(value);
    bits += 6;
    if (bits >= 8) out += static_cast<char>(group >> (bits -= 8) & 255);
  }
  return out;
}

template <class T>
inline constexpr const char* kTypeName = nullptr;
template <>
inline constexpr const char* kTypeName<float> = "f32";
template <>
inline constexpr const char* kTypeName<std::int32_t> = "i32";
template <>
inline constexpr const char* kTypeName<std::uint8_t> = "u8";

/// Numbers as their bytes, little-endian, row-major: docs/formats/report.md, "Contents of a
/// report".
template <class T>
Json packed(const std::vector<T>& values) {
  return {
      {"type", kTypeName<T>},
      {"bytes", base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)})}};
}
/// The numbers again; none where there is nothing packed.
template <class T>
std::vector<T> unpacked(const Json& json) {
  if (!json.is_object()) return {};
  const std::string bytes = from_base64(json.at("bytes").get_ref<const std::string&>());
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}
/// Entries of a matrix, row by row, each as a T.
template <class T, class Matrix>
Json packed_as(const Matrix& values) {
  std::vector<T> all;
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    for (Eigen::Index j = 0; j < values.cols(); ++j) all.push_back(static_cast<T>(values(i, j)));
  return packed(all);
}
/// Values of a list, each as a T.
template <class T, class Value>
Json packed_each(const std::vector<Value>& values) {
  std::vector<T> all;
  for (const Value value : values) all.push_back(static_cast<T>(value));
  return packed(all);
}

}  // namespace palpate::tools
