#include "libfem/mesh/read/raw_mesh.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <type_traits>
#include <variant>

#include "libfit/core/error.hpp"

namespace palpate::mesh_read {
namespace {

void refuse_compressed(std::string_view bytes, const std::string& name) {
  constexpr std::pair<std::string_view, const char*> kFirstBytes[] = {{"\x1f\x8b", "gzip"},
                                                                      {"PK\x03\x04", "zip"},
                                                                      {"BZh", "bzip2"},
                                                                      {"\xfd"
                                                                       "7zXZ",
                                                                       "xz"},
                                                                      {"\x28\xb5\x2f\xfd", "zstd"}};
  for (const auto& [first, format] : kFirstBytes)
    if (bytes.starts_with(first))
      throw Error(name, std::string("is compressed (") + format + ")", "Unpack it first.");
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

template <typename T>
T decode(const char* bytes, Encoding encoding) {
  std::array<char, sizeof(T)> copy;
  std::copy_n(bytes, sizeof(T), copy.begin());
  const bool is_native =
      (encoding == Encoding::little_endian) == (std::endian::native == std::endian::little);
  if (!is_native) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

// A zero of each NumberType, in its order.
constexpr std::variant<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
                       std::uint32_t, std::int64_t, std::uint64_t, float, double>
    kZeros[] = {std::int8_t{},   std::uint8_t{}, std::int16_t{},  std::uint16_t{}, std::int32_t{},
                std::uint32_t{}, std::int64_t{}, std::uint64_t{}, float{},         double{}};

// Calls use(T{}) with the C++ type that `type` stands for.
template <typename Use>
auto with_type(NumberType type, Use use) {
  return std::visit(use, kZeros[static_cast<std::size_t>(type)]);
}

template <typename T>
std::optional<T> parse(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);  // from_chars knows no plus sign
  T value{};
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<NumberType> number_type(std::string_view name) {
  using enum NumberType;
  constexpr std::pair<NumberType, std::array<std::string_view, 3>> kNames[] = {
      {int8, {"char", "int8", "signed_char"}},
      {uint8, {"uchar", "uint8", "unsigned_char"}},
      {int16, {"short", "int16"}},
      {uint16, {"ushort", "uint16", "unsigned_short"}},
      {int32, {"int", "int32", "vtkIdType"}},
      {uint32, {"uint", "uint32", "unsigned_int"}},
      {int64, {"long", "int64"}},
      {uint64, {"uint64", "unsigned_long"}},
      {float32, {"float", "float32"}},
      {float64, {"double", "float64"}}};
  constexpr std::string_view kPrefix = "vtktype";
  if (same_word(name.substr(0, kPrefix.size()), kPrefix)) name.remove_prefix(kPrefix.size());
  for (const auto& [type, names] : kNames)
    for (const std::string_view known : names)
      if (!name.empty() && same_word(name, known)) return type;
  return std::nullopt;
}

std::size_t size_of(NumberType type) {
  return with_type(type, [](auto number) { return sizeof(number); });
}

double decode_real(const char* bytes, NumberType type, Encoding encoding) {
  return with_type(type, [&](auto number) {
    return static_cast<double>(decode<decltype(number)>(bytes, encoding));
  });
}

std::int64_t decode_integer(const char* bytes, NumberType type, Encoding encoding) {
  return with_type(type, [&](auto number) {
    using T = decltype(number);
    const T value = decode<T>(bytes, encoding);
    // A value that is no index becomes one that every range check refuses.
    if constexpr (std::is_floating_point_v<T>) {
      return value >= 0 && value < 0x1p53 ? static_cast<std::int64_t>(value) : std::int64_t{-1};
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
      return value > static_cast<T>(std::numeric_limits<std::int64_t>::max())
                 ? std::int64_t{-1}
                 : static_cast<std::int64_t>(value);
    } else {
      return static_cast<std::int64_t>(value);
    }
  });
}

std::string load_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code fault;
  const auto status = std::filesystem::status(path, fault);
  if (!std::filesystem::exists(status))
    throw Error(name, "no such file",
                "Check the path; in a scene it starts at the scene's folder.");
  if (!std::filesystem::is_regular_file(status))
    throw Error(name, "is not a file", "Give the path of a mesh file.");
  const std::uintmax_t size = std::filesystem::file_size(path, fault);
  if (fault) throw Error(name, "cannot be read: " + fault.message(), "Check its permissions.");
  if (size == 0) throw Error(name, "the file is empty", "Export the mesh again.");
  if (size > std::uintmax_t{1} << 32)
    throw Error(name, "is larger than 4 GiB", "Decimate the mesh, or save it in a binary format.");
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) throw Error(name, "cannot be read", "Check that the file is there and may be read.");
  refuse_compressed(bytes, name);
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.erase(0, 3);
  return bytes;
}

std::optional<double> parse_real(std::string_view word) { return parse<double>(word); }
std::optional<std::int64_t> parse_integer(std::string_view word) {
  return parse<std::int64_t>(word);
}

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

std::string quoted(std::string_view word) {
  std::string out = "'";
  for (const char c : word.substr(0, 24)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (word.size() > 24 ? "...'" : "'");
}

double Cursor::coordinate(double value, const std::string& place) const {
  const double size = std::abs(value);
  const char* fault = std::isnan(value)   ? "is not a number (NaN)"
                      : std::isinf(value) ? "is infinite"
                      : size > 1e15       ? "is absurdly large (above 1e15)"
                      : size != 0 && size < static_cast<double>(std::numeric_limits<float>::min())
                          ? "is absurdly small (below 1.2e-38)"
                          : nullptr;
  if (fault != nullptr)
    fail(std::string("a coordinate ") + fault + place,
         "Find the vertex in the program that made the mesh, and export it again.");
  return value;
}

void Cursor::seek(std::size_t position) {
  if (position > bytes_.size()) fail("the file ends too early");
  at_ = last_ = position;
}

bool Cursor::at_end() {
  while (at_ < bytes_.size()) {
    const char c = bytes_[at_];
    if (is_blank(c) || is_line_end(c)) {
      ++at_;
    } else if (comment != '\0' && c == comment) {
      line();
    } else {
      return false;
    }
  }
  return true;
}

std::string_view Cursor::word() {
  if (at_end()) fail_at(at_, "the file ends too early");
  return word_on_line();
}

std::string_view Cursor::word_on_line() {
  while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
  last_ = at_;
  if (at_ < bytes_.size() && comment != '\0' && bytes_[at_] == comment) return {};
  while (at_ < bytes_.size() && !is_blank(bytes_[at_]) && !is_line_end(bytes_[at_])) ++at_;
  return bytes_.substr(last_, at_ - last_);
}

std::string_view Cursor::line() {
  last_ = at_;
  const std::size_t end = std::min(bytes_.find_first_of("\r\n", at_), bytes_.size());
  at_ = end;
  if (at_ < bytes_.size()) at_ += bytes_.substr(at_, 2) == "\r\n" ? 2 : 1;
  return bytes_.substr(last_, end - last_);
}

void Cursor::expect(std::string_view keyword) {
  const std::string_view found = word();
  if (!same_word(found, keyword))
    fail("expected '" + std::string(keyword) + "', found " + quoted(found));
}

std::string_view Cursor::take(std::size_t number) {
  last_ = at_;
  if (number > remaining()) fail("the file ends too early");
  at_ += number;
  return bytes_.substr(last_, number);
}

double Cursor::real(NumberType type) {
  if (encoding != Encoding::text) return decode_real(take(size_of(type)).data(), type, encoding);
  const std::string_view found = word();
  if (const auto value = parse_real(found)) return *value;
  fail(quoted(found) + " is not a number", found.find(',') != std::string_view::npos
                                               ? "Write decimals with a point, not a comma."
                                               : kExportAgain);
}

std::int64_t Cursor::integer(NumberType type) {
  if (encoding != Encoding::text) return decode_integer(take(size_of(type)).data(), type, encoding);
  const std::string_view found = word();
  if (const auto value = parse_integer(found)) return *value;
  fail(quoted(found) + " is not a whole number");
}

Vec3 Cursor::position_3d(NumberType type) {
  Vec3 point;
  for (double& x : point) x = coordinate(real(type));
  return point;
}

std::size_t Cursor::count(NumberType type, std::size_t min_bytes, std::string_view things) {
  return checked_count(integer(type), min_bytes, things);
}

std::size_t Cursor::checked_count(std::int64_t number, std::size_t min_bytes,
                                  std::string_view things) {
  if (number < 0 || number > std::numeric_limits<std::int32_t>::max())
    fail("the number of " + std::string(things) + " is not between 0 and 2^31 - 1");
  if (static_cast<std::size_t>(number) > remaining() / std::max<std::size_t>(min_bytes, 1))
    fail("announces " + std::to_string(number) + " " + std::string(things) +
             ", more than the rest of the file can hold",
         "The file is cut short or damaged; copy or export it again.");
  return number;
}

std::string Cursor::where() const {
  if (encoding != Encoding::text) return file_ + ": byte " + std::to_string(last_);
  const std::string_view before = bytes_.substr(0, last_);
  std::size_t number = 1;
  for (std::size_t i = 0; i < before.size(); ++i)
    number += before[i] == '\n' || (before[i] == '\r' && bytes_.substr(i + 1, 1) != "\n");
  return file_ + ":" + std::to_string(number);
}

void Cursor::fail(const std::string& what, const std::string& remedy) const {
  throw Error(where(), what, remedy);
}

void Cursor::fail_at(std::size_t position, const std::string& what,
                     const std::string& remedy) const {
  Cursor there = *this;
  there.last_ = position;
  there.fail(what, remedy);
}

}  // namespace palpate::mesh_read
