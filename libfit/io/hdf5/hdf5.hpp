#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate {

/// Named strings that travel with a file, as root attributes: what it was made from
/// (`inputs_hash`, 16 hex digits), a statement in JSON, and so on.
using Attributes = std::map<std::string, std::string>;

namespace h5 {

/// Owns one HDF5 identifier (hid_t) and gives it back with the function that suits its kind.
class Handle {
 public:
  Handle() = default;
  Handle(std::int64_t id, int (*close)(std::int64_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(other.release()), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_), std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }

  std::int64_t id() const { return id_; }
  bool is_valid() const { return id_ >= 0; }
  /// Hands the identifier over; the caller closes it.
  std::int64_t release() { return std::exchange(id_, -1); }

 private:
  std::int64_t id_ = -1;
  int (*close_)(std::int64_t) = nullptr;
};

/// Stops HDF5 from printing its error stack; for the calling thread.
void silence();

/// Root cause in HDF5's own words from its error stack, "" without one; clears the stack.
std::string take_reason();

/// Rows and columns of a data set; `columns` 0 means one-dimensional.
struct Shape {
  std::size_t rows = 0;
  std::size_t columns = 0;

  std::size_t count() const { return rows * (columns == 0 ? 1 : columns); }
  bool operator==(const Shape&) const = default;
};
/// "12", "12 x 3".
std::string to_string(const Shape& shape);

/// Root attribute of every format, `version` (docs/formats.md).
inline constexpr int kFileVersion = 1;

/// Wildcard in the shape a reader expects.
inline constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();

/// Unit of data sets without dimension: indices, codes, unit vectors, names.
inline constexpr std::string_view kNoUnit = "1";
/// For a rig's files, whose units the manifest says: the attribute is not looked at.
inline constexpr std::string_view kAnyUnit = "*";

/// Makes one HDF5 file in memory and stores it whole or not at all (AtomicFile).
/// Same content, same bytes: no dates, no host names, arrays row-major, chunks compressed
/// (deflate) and guarded by checksums, HDF5 1.10 format.
/// Throws Error naming the file, and the data set where one is concerned.
class Writer {
 public:
  Writer(const std::filesystem::path& path, std::string_view schema, const Attributes& attributes);

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

  /// Stores the file. Call it once, last.
  void commit();

 private:
  void put(const std::string& name, std::string_view unit, std::int64_t type, const void* data,
           Shape shape);
  Handle group_of(const std::string& name);
  Handle open(const std::string& object);
  void put_attribute(const std::string& object, const std::string& name, std::int64_t type,
                     const Handle& space, const void* data);
  void put_texts(const std::string& object, const std::string& name,
                 const std::vector<std::string>& values, const Handle& space);
  void check(std::int64_t result, const std::string& name, const std::string& what) const;

  std::filesystem::path path_;
  AtomicFile stored_;
  Handle file_;
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

  /// Throws Error unless the root says `schema` and kFileVersion.
  void expect(std::string_view schema) const;

  bool has(const std::string& name) const;
  /// Values row by row. shape: what is expected, kAny where free (`columns` kAny: two-dimensional).
  /// The unit attribute must be there and equal `unit` (but for kAnyUnit). may_be_nan: NaN (never
  /// inf) is let through.
  std::vector<double> numbers(const std::string& name, std::string_view unit, Shape shape,
                              bool may_be_nan = false) const;
  /// T: std::int32_t or std::int8_t.
  template <class T = std::int32_t>
  std::vector<T> integers(const std::string& name, std::string_view unit, Shape shape) const;
  std::vector<std::string> strings(const std::string& name, std::size_t rows) const;
  /// Shape of a data set of one or two dimensions.
  Shape shape_of(const std::string& name) const;

  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  /// Empty where there is no such attribute.
  std::string text_if_any(const std::string& object, const std::string& name) const;
  std::vector<std::string> texts_attribute(const std::string& object,
                                           const std::string& name) const;
  std::int64_t integer_attribute(const std::string& object, const std::string& name) const;
  /// All string attributes of the root.
  Attributes root_texts() const;

  /// Paths of all data sets, sorted; "float64", "int8", "string", ...
  std::vector<std::string> data_sets() const;
  std::string type_of(const std::string& name) const;

  /// The error a caller throws on content it finds wrong.
  Error error(const std::string& name, const std::string& what) const;

 private:
  /// A data set whose unit, shape, type and storage are as expected.
  struct CheckedSet {
    Handle set, type;
    Shape shape;
  };
  struct OpenAttribute {
    Handle attribute, type, space;
  };

  Handle open_data_set(const std::string& name) const;
  Handle open_object(const std::string& object) const;
  OpenAttribute open_attribute(const std::string& object, const std::string& name) const;
  CheckedSet open_checked(const std::string& name, std::string_view unit, Shape expected,
                          int type_class, const char* type_name) const;
  Shape checked_shape(const Handle& set, const std::string& name, Shape expected) const;
  void check_storage(const Handle& set, const std::string& name, std::size_t count) const;
  void check_unit(const Handle& set, const std::string& name, std::string_view unit) const;
  template <class T>
  std::vector<T> values(const CheckedSet& of, const std::string& name,
                        std::int64_t memory_type) const;
  Error attribute_error(const std::string& object, const std::string& name,
                        const std::string& what) const {
    return error(object, "attribute `" + name + "` " + what);
  }

  std::filesystem::path path_;
  std::string remedy_;
  std::uintmax_t file_bytes_ = 0;
  Handle file_;
};

}  // namespace h5
}  // namespace palpate
