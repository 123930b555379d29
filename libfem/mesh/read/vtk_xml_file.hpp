#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/mesh/read/cursor.hpp"

namespace palpate::mesh_read {

/// A <DataArray> of a VTK XML file: where its numbers are and how they are written.
struct VtkArray {
  std::string section;  ///< the element around it: Points, Polys, Cells, ...
  std::string name;
  NumberType type = NumberType::float64;
  std::string format;        ///< ascii, binary (inline base64) or appended
  std::size_t content = 0;   ///< byte after the tag
  std::int64_t offset = -1;  ///< into the appended data
};

/// A <Piece>: its counts (0 where absent) and arrays.
struct VtkPiece {
  std::int64_t points = 0, cells = 0, verts = 0, lines = 0, polys = 0, strips = 0;
  std::vector<VtkArray> arrays;
};

/// A VTK XML file of one data set type, its tags read, its arrays read on demand.
/// ASCII, inline base64, appended raw and appended base64; zlib-compressed or not; 32 and 64 bit
/// headers; both byte orders. Safe on untrusted bytes.
class VtkXmlFile {
 public:
  /// type: PolyData or UnstructuredGrid. Throws Error when the file is of another type, or written
  /// with a compressor other than zlib.
  VtkXmlFile(Cursor& file, std::string_view type);

  const std::vector<VtkPiece>& pieces() const { return pieces_; }

  /// The numbers of the array `name` in `section` of a piece (empty name: the section's first).
  /// Throws when there is none, or it has not exactly `number` values (any number if negative).
  std::vector<double> reals(const VtkPiece& piece, std::string_view section, std::string_view name,
                            std::int64_t number) const;
  std::vector<std::int64_t> integers(const VtkPiece& piece, std::string_view section,
                                     std::string_view name, std::int64_t number) const;

  /// The first text of the array of texts `name` in the file's field data; empty where it has none.
  std::string field_text(std::string_view name) const;

 private:
  const VtkArray& find(const VtkPiece& piece, std::string_view section,
                       std::string_view name) const;
  std::string bytes_of(const VtkArray& array) const;
  std::string unpack(std::string_view block, std::size_t position) const;
  std::string inflate(std::string_view block, std::size_t position) const;

  Cursor& file_;
  std::vector<VtkPiece> pieces_;
  VtkPiece fields_;  // arrays of texts in <FieldData>
  Encoding byte_order_ = Encoding::little_endian;
  NumberType header_ = NumberType::uint32;
  bool is_compressed_ = false;
  bool is_appended_base64_ = false;
  std::size_t appended_ = 0;  // byte after the underscore
};

/// <name attributes> or </name>.
struct XmlTag {
  std::string_view name;
  std::string_view attributes;
  bool is_end = false;     ///< </name>
  bool is_closed = false;  ///< <name/>
  std::size_t after = 0;   ///< byte after the tag
};

/// The next tag from the cursor's position, which moves past it; none when there is no more.
/// Passes over text, comments and processing instructions. Safe on untrusted bytes. This is all of
/// XML that VTK needs; its appended raw bytes are no XML, so a general parser would refuse them.
std::optional<XmlTag> next_tag(Cursor& file);

/// Value of an attribute of the tag; empty when it has none.
std::string_view attribute(const XmlTag& tag, std::string_view name);

}  // namespace palpate::mesh_read
