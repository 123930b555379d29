#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libfem/mesh/read/read.hpp"
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
  /// The next bytes.
  std::string_view take(std::size_t number);
  /// The number, which must be a coordinate: 0 or of magnitude 1.2e-38 (least normal float32: below
  /// it are misread bytes) to 1e15 file units. place: of it, for the message.
  double coordinate(double value, const std::string& place = "") const;

  /// "file:line" or "file: byte n", of what was taken last.
  std::string where() const;
  [[noreturn]] void fail(const std::string& what, const std::string& remedy = kExportAgain) const;
  /// As fail, about the given place.
  [[noreturn]] void fail_at(std::size_t position, const std::string& what,
                            const std::string& remedy = kExportAgain) const;

  static constexpr const char* kExportAgain =
      "The file is damaged or not of its extension's format; export it again.";

 private:
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

/// Number of `type` at the front of at least size_of(type) bytes.
double decode_real(const char* bytes, NumberType type, Encoding encoding);
std::int64_t decode_integer(const char* bytes, NumberType type, Encoding encoding);

/// Result of a reader, in file units: triangles of a surface, or tets. Corners index `points`
/// (checked by the reader, or by add_polygon and add_tet). tet_id: the file's own number of each
/// tet, for messages.
struct RawMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::array<std::int32_t, 4>> tets;
  std::vector<std::int64_t> tet_id;
  std::size_t ignored_elements = 0;
};

/// Groups of a file's cells. A reader fills it where it is asked to; cells are counted as the file
/// counts them, from 0.
struct RawLabels {
  struct Group {
    std::string name;
    int dimension = 2;
    std::vector<std::int32_t> cells;
  };
  std::vector<Group> groups;
  std::int32_t cells = 0;
  std::vector<std::int32_t> cell;                  ///< that each triangle or tet is made of
  std::vector<std::array<std::int32_t, 3>> faces;  ///< triangles in a file of tets
  std::vector<std::int32_t> face_cell;

  /// The group of this name, made where there is none.
  Group& group(std::string_view name, int dimension);
};

/// Adds a polygon as a fan about its first corner. corners: indices into `points`, at least 3.
/// Throws through `cursor` (which says where) when there are fewer or one is out of range.
void add_polygon(RawMesh& surface, std::span<const std::int64_t> corners, const Cursor& cursor);

/// Adds a tet by its four corner indices, checked as in add_polygon.
void add_tet(RawMesh& mesh, std::span<const std::int64_t, 4> corners, std::int64_t id,
             const Cursor& cursor);

/// The element kinds that share a file with tets.
[[noreturn]] void fail_not_tets(const Cursor& cursor, std::string_view kind);

/// The surface or the tets of a file by its extension, in file units; labels: null, or its groups.
RawMesh read_raw(const std::filesystem::path& path, bool is_tets, RawLabels* labels);

/// A tet mesh in m from a reader's raw one: unused nodes and duplicate tets dropped, negative tets
/// turned.
/// where: the file, for messages. Throws Error when tets have no volume or use a node twice, or two
/// tets lie on the same side of a shared face (they overlap), or three share one.
TetMesh settle_tets(RawMesh raw, double length_unit_m, const std::string& where,
                    TetReadNotes& notes);

// One reader per format, each in its own .cpp. A reader gets a cursor at the start of the file's
// bytes and fills a raw mesh, or throws Error naming the place. All are safe on untrusted bytes.
// labels: the groups, where the format has such (OBJ, MSH); null: passed over, so that nothing in
// them is refused.

RawMesh read_obj(Cursor& file, RawLabels* labels);
RawMesh read_stl(Cursor& file, RawLabels* labels);
RawMesh read_ply(Cursor& file, RawLabels* labels);
RawMesh read_off(Cursor& file, RawLabels* labels);
RawMesh read_vtk_polydata(Cursor& file, RawLabels* labels);

RawMesh read_msh(Cursor& file, RawLabels* labels);
RawMesh read_vtk_grid(Cursor& file, RawLabels* labels);

}  // namespace palpate::mesh_read
