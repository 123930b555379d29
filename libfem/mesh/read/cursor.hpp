#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "libfit/core/geometry.hpp"

namespace palpate::mesh_read {

/// Encoding of the numbers in a file or in a part of it.
enum class Encoding { text, little_endian, big_endian };

enum class NumberType {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

/// The type that PLY, VTK or C calls so, in any case; none unless one does.
std::optional<NumberType> number_type(std::string_view name);

/// Bytes that a number of this type takes in binary.
std::size_t size_of(NumberType type);

/// A whole file in memory, without a byte-order mark of UTF-8. Throws Error when it is missing, no
/// regular file, empty or over 4 GiB.
std::string load_file(const std::filesystem::path& path);

/// A place in a file's bytes that moves forward as words, lines and numbers are taken.
/// Never reads past the end: every function throws Error, naming file and line (text) or byte
/// offset (binary), where the bytes are not what was asked for. Safe on untrusted bytes.
/// The bytes must outlive the cursor.
class Cursor {
 public:
  Cursor(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  Encoding encoding = Encoding::text;
  char comment = '\0';  ///< at the start of a word it makes the rest of the line a comment; 0: none

  std::size_t position() const { return at_; }
  std::size_t remaining() const { return bytes_.size() - at_; }
  std::string_view bytes() const { return bytes_; }
  const std::string& file() const { return file_; }
  void seek(std::size_t position);

  /// Skips blanks and comments; true when nothing is left.
  bool at_end();
  /// The next word, skipping blanks, line ends and comments.
  std::string_view word();
  /// The next word on the present line, empty when the line has no more.
  std::string_view word_on_line();
  /// The rest of the present line (without its end), and moves past it. LF, CRLF and CR all end
  /// one.
  std::string_view line();
  /// The next word must be this one, in any case.
  void expect(std::string_view keyword);

  /// The next number, as text or as bytes of `type` according to `encoding`.
  double real(NumberType type = NumberType::float64);
  std::int64_t integer(NumberType type = NumberType::int64);
  /// Three numbers that can be a position: finite and of plausible magnitude.
  Vec3 position_3d(NumberType type = NumberType::float64);
  /// A count of things that each take at least `min_bytes` of what is left of the file.
  std::size_t count(NumberType type, std::size_t min_bytes, std::string_view things);
  /// Throws unless what is left of the file can hold `number` things of `min_bytes` each.
  std::size_t checked_count(std::int64_t number, std::size_t min_bytes, std::string_view things);
  void skip_bytes(std::size_t number);

  /// "file:line" or "file: byte n", of what was taken last.
  std::string where() const;
  [[noreturn]] void fail(const std::string& what, const std::string& remedy = kExportAgain) const;
  /// As fail, about the given place.
  [[noreturn]] void fail_at(std::size_t position, const std::string& what,
                            const std::string& remedy = kExportAgain) const;

  static constexpr const char* kExportAgain =
      "The file is damaged or not of its extension's format; export it again.";

 private:
  std::string_view take(std::size_t number);

  std::string_view bytes_;
  std::string file_;
  std::size_t at_ = 0;
  std::size_t last_ = 0;  // start of what was taken last
};

/// A number as text; none unless the whole word is one that the type can hold.
std::optional<double> parse_real(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

/// True where words agree but for the case of ASCII letters.
bool same_word(std::string_view a, std::string_view b);

/// A word of the file for an error message: in quotes, short and printable.
std::string quoted(std::string_view word);

/// Why a coordinate cannot be meant, or empty. A coordinate is 0 or of magnitude 1.2e-38 (least
/// normal float32: below it are misread bytes) to 1e15 file units.
std::string coordinate_fault(double value);

/// Number of `type` at the front of at least size_of(type) bytes.
double decode_real(const char* bytes, NumberType type, Encoding encoding);
std::int64_t decode_integer(const char* bytes, NumberType type, Encoding encoding);

}  // namespace palpate::mesh_read
