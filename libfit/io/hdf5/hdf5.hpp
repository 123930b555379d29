#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/hdf5/handle.hpp"

namespace palpate {

/// Named strings that travel with a file, as root attributes: what it was made from
/// (`inputs_hash`, 16 hex digits), a statement in JSON, and so on.
using Attributes = std::map<std::string, std::string>;

namespace h5 {

/// Rows and columns of a data set; `columns` 0 means one-dimensional.
struct Shape {
  std::size_t rows = 0;
  std::size_t columns = 0;

  std::size_t count() const { return rows * (columns == 0 ? 1 : columns); }
  bool operator==(const Shape&) const = default;
};
/// "12", "12 x 3".
std::string to_string(const Shape& shape);

/// Rows of a data set, one after another; none at all means every row.
struct RowRange {
  std::size_t first = 0, count = 0;
};
using Rows = std::optional<std::vector<RowRange>>;

/// Wildcard in the shape a reader expects.
inline constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();

/// Unit of data sets without dimension: indices, codes, unit vectors, names.
inline constexpr std::string_view kNoUnit = "1";
/// For a rig's files, whose units the manifest says: the attribute is not looked at.
inline constexpr std::string_view kAnyUnit = "*";

/// Makes one HDF5 file in memory and stores it whole or not at all (AtomicFile).
/// Same content, same bytes: no dates, no host names, arrays row-major, chunks compressed
/// (deflate) and guarded by checksums, HDF5 1.10 format. Chunks that the file to be replaced, or
/// `earlier` where one is named, has already are copied from it packed: the bytes are the same.
/// Throws Error naming the file, and the data set where one is concerned.
class Writer {
 public:
  Writer(const std::filesystem::path& path, std::string_view schema, int version,
         const Attributes& attributes, const std::filesystem::path& earlier = {});

  /// Data sets by path, "rows/force"; groups are made as needed. data: shape.count() values.
  void numbers(const std::string& name, std::string_view unit, const double* data, Shape shape);
  void integers(const std::string& name, std::string_view unit, const std::int32_t* data,
                Shape shape);
  void bytes(const std::string& name, std::string_view unit, const std::int8_t* data, Shape shape);
  /// UTF-8; a string that holds a zero byte is refused (HDF5 would cut it there).
  void strings(const std::string& name, const std::vector<std::string>& values);

  /// Attributes of a group or data set that exists; "" is the root.
  void attribute(const std::string& object, const std::string& name, std::string_view value);
  void attribute(const std::string& object, const std::string& name, std::int32_t value);
  void attribute(const std::string& object, const std::string& name,
                 const std::vector<std::string>& values);

  /// Hash of a data set's chunks as they are stored; 0 for one without values.
  std::uint64_t stored_hash(const std::string& name) const;

  /// Stores the file. Call it once, last.
  void commit();

 private:
  void put(const std::string& name, std::string_view unit, std::int64_t type, const void* data,
           Shape shape);
  void put_chunks(const Handle& set, const std::string& name, const char* data, Shape shape,
                  std::size_t value_bytes);
  Handle group_of(const std::string& name);
  Handle open(const std::string& object);
  void put_attribute(std::int64_t object, const std::string& name, std::int64_t type,
                     std::int64_t space, const void* data);
  void check(std::int64_t result, const std::string& name, const std::string& what) const;

  std::filesystem::path path_;
  AtomicFile stored_;
  Handle earlier_;
  Handle file_;
  std::map<std::string, std::uint64_t> stored_hash_;
};

/// Reads one HDF5 file, trusting nothing in it: kind, version, unit, type, shape, storage and
/// finiteness are checked before a value is handed out. Also reads files that others made: any
/// float or integer width that fits, strings of fixed or variable length.
/// Safe on damaged bytes as far as HDF5 1.10 itself is; virtual and external storage is refused.
/// Every Error names the file and the data set and ends with `remedy`.
class Reader {
 public:
  /// Opens any HDF5 file. Throws Error when it is missing, no HDF5 file or cut short.
  Reader(const std::filesystem::path& path, std::string remedy);

  /// Throws Error unless the root says `schema` and a version 1..newest.
  void expect(std::string_view schema, int newest) const;

  bool has(const std::string& name) const;
  /// Values row by row. shape: what is expected, kAny where free (`columns` kAny: two-dimensional).
  /// The unit attribute must be there and equal `unit` (but for kAnyUnit). may_be_nan: NaN (never
  /// inf) is let through. rows: those to read, in order, of a data set of that shape.
  std::vector<double> numbers(const std::string& name, std::string_view unit, Shape shape,
                              bool may_be_nan = false, const Rows& rows = {}) const;
  std::vector<std::int32_t> integers(const std::string& name, std::string_view unit, Shape shape,
                                     const Rows& rows = {}) const;
  std::vector<std::int8_t> bytes(const std::string& name, std::string_view unit, Shape shape,
                                 const Rows& rows = {}) const;
  std::vector<std::string> strings(const std::string& name, std::size_t rows) const;
  /// As Writer::stored_hash, from the bytes as they are; 0 where chunks are missing or packed
  /// otherwise.
  std::uint64_t stored_hash(const std::string& name) const;
  /// Shape of a data set of one or two dimensions.
  Shape shape_of(const std::string& name) const;

  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  std::vector<std::string> texts_attribute(const std::string& object,
                                           const std::string& name) const;
  std::int64_t integer_attribute(const std::string& object, const std::string& name) const;
  /// All string attributes of the root.
  Attributes root_texts() const;

  /// Paths of all data sets, sorted; "float64", "int8", "string", ...; "" without unit attribute.
  std::vector<std::string> data_sets() const;
  std::string type_of(const std::string& name) const;
  std::string unit_of(const std::string& name) const;

  /// The error a caller throws on content it finds wrong.
  Error error(const std::string& name, const std::string& what) const;

 private:
  Handle open_data_set(const std::string& name) const;
  Handle open_object(const std::string& object) const;
  Handle open_attribute(const std::string& object, const std::string& name) const;
  Shape checked_shape(const Handle& set, const std::string& name, Shape expected) const;
  void check_storage(const Handle& set, const std::string& name, std::size_t count) const;
  void check_unit(const Handle& set, const std::string& name, std::string_view unit) const;
  template <class T>
  std::vector<T> integers_as(const std::string& name, std::string_view unit, Shape shape,
                             const Rows& rows) const;
  /// Values of the rows asked for, as `memory_type` of T.
  template <class T>
  std::vector<T> values(const Handle& set, const std::string& name, std::int64_t memory_type,
                        Shape shape, const Rows& rows) const;
  Error attribute_error(const std::string& object, const std::string& name,
                        const std::string& what) const;

  std::filesystem::path path_;
  std::string remedy_;
  std::uintmax_t file_bytes_ = 0;
  Handle file_;
};

}  // namespace h5
}  // namespace palpate
