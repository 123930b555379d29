#include <fmt/core.h>

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <type_traits>

#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate::h5 {
namespace fs = std::filesystem;

static_assert(std::is_same_v<hid_t, std::int64_t>, "HDF5 1.10 or later");

void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

std::string take_reason() {
  std::string reason;
  const auto keep_first = [](unsigned, const H5E_error2_t* entry, void* out) -> herr_t {
    auto& text = *static_cast<std::string*>(out);
    if (text.empty() && entry->desc != nullptr) text = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason;
}

namespace {

// "N m" may be written with a middle dot or a star by others; "1" as nothing.
std::string plain_unit(std::string unit) {
  for (const std::string_view dot : {"\u00b7", "\u22c5", "*", "."})
    if (const auto at = unit.find(dot); at != std::string::npos)
      unit.replace(at, dot.size(), 1, ' ');
  return unit.empty() ? std::string(kNoUnit) : unit;
}

// Chunks that were never written would read as zeros. (H5Dget_space_status calls every compressed
// data set partly allocated, so chunks are counted.)
bool is_written_whole(const Handle& set, const Handle& creation) {
  if (H5Pget_layout(creation.id()) != H5D_CHUNKED) {
    H5D_space_status_t status;
    return H5Dget_space_status(set.id(), &status) >= 0 && status == H5D_SPACE_STATUS_ALLOCATED;
  }
  hsize_t chunk[2] = {1, 1}, dims[2] = {1, 1}, found = 0, expected = 1;
  const Handle space(H5Dget_space(set.id()), H5Sclose);
  H5Sget_simple_extent_dims(space.id(), dims, nullptr);
  H5Pget_chunk(creation.id(), 2, chunk);
  for (int k = 0; k < 2; ++k) expected *= (dims[k] + chunk[k] - 1) / chunk[k];
  return H5Dget_num_chunks(set.id(), space.id(), &found) >= 0 && found == expected;
}

bool is_hard_link(hid_t file, const std::string& path) {
  H5L_info_t info;
  return H5Lexists(file, path.c_str(), H5P_DEFAULT) > 0 &&
         H5Lget_info(file, path.c_str(), &info, H5P_DEFAULT) >= 0 && info.type == H5L_TYPE_HARD;
}

/// Fetches all values as a memory type into a buffer, negative on failure.
using ReadValues = std::function<int(std::int64_t memory_type, void* buffer)>;

std::string trimmed(const char* field, std::size_t size, bool is_space_padded) {
  std::size_t length = ::strnlen(field, size);
  while (is_space_padded && length > 0 && field[length - 1] == ' ') --length;
  return std::string(field, length);
}

// Appends `count` texts of fixed or variable length, without their padding. The file's own type is
// the memory type: HDF5 does not convert between character sets.
bool read_strings(const Handle& type, const Handle& space, std::size_t count,
                  const ReadValues& read, std::vector<std::string>& out) {
  if (H5Tis_variable_str(type.id()) > 0) {
    std::vector<char*> texts(count, nullptr);
    if (read(type.id(), texts.data()) < 0) return false;
    for (const char* text : texts) out.emplace_back(text != nullptr ? text : "");
    H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, texts.data());
    return true;
  }
  const std::size_t size = H5Tget_size(type.id());
  std::vector<char> packed(count * size);
  if (read(type.id(), packed.data()) < 0) return false;
  const bool is_space_padded = H5Tget_strpad(type.id()) == H5T_STR_SPACEPAD;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(trimmed(packed.data() + i * size, size, is_space_padded));
  return true;
}

}  // namespace

std::string to_string(const Shape& shape) {
  const auto word = [](std::size_t n) {
    return n == kAny ? std::string("any") : std::to_string(n);
  };
  return shape.columns == 0 ? word(shape.rows)
                            : fmt::format("{} x {}", word(shape.rows), word(shape.columns));
}

Reader::Reader(const fs::path& path, std::string remedy) : path_(path), remedy_(std::move(remedy)) {
  silence();
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw Error(path.string(), "no such file", "Check the name.");
  if (!fs::is_regular_file(path, ignored))
    throw Error(path.string(), "is not a regular file", "Name a file.");
  file_bytes_ = fs::file_size(path, ignored);
  const htri_t is_hdf5 = H5Fis_hdf5(path.c_str());
  if (is_hdf5 < 0) throw Error(path.string(), "cannot be read", "Check its permissions.");
  if (is_hdf5 == 0) throw error("", "is not an HDF5 file, or its beginning is damaged");
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access.id(), H5F_CLOSE_STRONG);
  H5Pset_file_locking(access.id(), false, true);  // reads from read-only media, too
  file_ = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!file_.is_valid()) throw error("", "is damaged or cut short (HDF5: " + take_reason() + ")");
}

Error Reader::error(const std::string& name, const std::string& what) const {
  return Error(path_.string() + (name.empty() ? "" : ":" + name), what, remedy_);
}

void Reader::expect(std::string_view schema) const {
  const std::string found = text_if_any("", "schema");
  if (found != schema)
    throw error("", (found.empty() ? "has no schema" : "holds `" + found + "`") + ", not `" +
                        std::string(schema) + "`");
  const std::int64_t version = integer_attribute("", "version");
  if (version != kFileVersion)
    throw error("", fmt::format("has version {}, not {}", version, kFileVersion));
}

// Every step of the path must be a hard link: soft and external links lead to other places.
bool Reader::has(const std::string& name) const {
  for (std::size_t at = name.find('/'); at != std::string::npos; at = name.find('/', at + 1))
    if (!is_hard_link(file_.id(), name.substr(0, at))) return false;
  return is_hard_link(file_.id(), name);
}

Handle Reader::open_object(const std::string& object) const {
  if (!object.empty() && !has(object)) throw error(object, "is missing");
  Handle handle(H5Oopen(file_.id(), object.empty() ? "/" : object.c_str(), H5P_DEFAULT), H5Oclose);
  if (!handle.is_valid()) throw error(object, "cannot be opened (HDF5: " + take_reason() + ")");
  return handle;
}

Handle Reader::open_data_set(const std::string& name) const {
  if (!has(name)) throw error(name, "data set is missing");
  Handle set(H5Dopen2(file_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.is_valid()) throw error(name, "is no readable data set (HDF5: " + take_reason() + ")");
  return set;
}

Shape Reader::shape_of(const std::string& name) const {
  return checked_shape(open_data_set(name), name, {kAny, kAny});
}

Shape Reader::checked_shape(const Handle& set, const std::string& name, Shape expected) const {
  const Handle space(H5Dget_space(set.id()), H5Sclose);
  const int dimensions = H5Sget_simple_extent_ndims(space.id());
  const bool is_any = expected == Shape{kAny, kAny};
  if (dimensions < 1 || dimensions > 2)
    throw error(name, fmt::format("has {} dimensions, not 1 or 2", dimensions));
  hsize_t dims[2] = {0, 0};
  H5Sget_simple_extent_dims(space.id(), dims, nullptr);
  const Shape found{dims[0], dims[1]};
  // Products of claimed extents stay below 2^64.
  if (dims[0] > hsize_t{1} << 40 || dims[1] > hsize_t{1} << 16)
    throw error(name, "claims shape " + to_string(found));
  if (is_any) return found;
  const bool fits = (dimensions == 2) == (expected.columns != 0) &&
                    (expected.rows == kAny || expected.rows == found.rows) &&
                    (expected.columns == kAny || expected.columns == found.columns);
  if (!fits)
    throw error(name, fmt::format("has shape {}, not {}", to_string(found), to_string(expected)));
  return found;
}

void Reader::check_storage(const Handle& set, const std::string& name, std::size_t count) const {
  if (count == 0) return;
  const std::size_t value_bytes = H5Tget_size(Handle(H5Dget_type(set.id()), H5Tclose).id());
  const Handle creation(H5Dget_create_plist(set.id()), H5Pclose);
  if (H5Pget_layout(creation.id()) == H5D_VIRTUAL || H5Pget_external_count(creation.id()) > 0)
    throw error(name, "keeps its values in another file");
  // Deflate packs at most 1032:1: more is a lie.
  if (value_bytes == 0 || count > 1100 * file_bytes_ / value_bytes)
    throw error(name, fmt::format("claims {} values in a file of {} bytes", count, file_bytes_));
  if (!is_written_whole(set, creation)) throw error(name, "was not written whole");
}

void Reader::check_unit(const Handle& set, const std::string& name, std::string_view unit) const {
  if (unit == kAnyUnit) return;
  if (H5Aexists(set.id(), "unit") <= 0)
    throw error(name, "has no `unit` attribute, expected " + std::string(unit));
  const std::string found = text_attribute(name, "unit");
  if (plain_unit(found) != plain_unit(std::string(unit)))
    throw error(name, "is in `" + found + "`, not in " + std::string(unit));
}

Reader::CheckedSet Reader::open_checked(const std::string& name, std::string_view unit,
                                        Shape expected, int type_class,
                                        const char* type_name) const {
  Handle set = open_data_set(name);
  check_unit(set, name, unit);
  const Shape shape = checked_shape(set, name, expected);
  Handle type(H5Dget_type(set.id()), H5Tclose);
  if (H5Tget_class(type.id()) != type_class)
    throw error(name, fmt::format("holds {}, not {}", type_of(name), type_name));
  check_storage(set, name, shape.count());
  return {std::move(set), std::move(type), shape};
}

template <class T>
std::vector<T> Reader::values(const CheckedSet& of, const std::string& name,
                              std::int64_t memory_type) const {
  std::vector<T> out(of.shape.count());
  if (!out.empty() &&
      H5Dread(of.set.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.data()) < 0)
    throw error(name, "cannot be read (HDF5: " + take_reason() + ")");
  return out;
}

std::vector<double> Reader::numbers(const std::string& name, std::string_view unit, Shape expected,
                                    bool may_be_nan) const {
  const CheckedSet of = open_checked(name, unit, expected, H5T_FLOAT, "floating-point numbers");
  std::vector<double> out = values<double>(of, name, H5T_NATIVE_DOUBLE);
  const std::size_t columns = of.shape.columns == 0 ? 1 : of.shape.columns;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (!std::isfinite(out[i]) && !(may_be_nan && std::isnan(out[i])))
      throw error(name, fmt::format("row {} is not a finite number", i / columns));
  return out;
}

template <class T>
std::vector<T> Reader::integers(const std::string& name, std::string_view unit,
                                Shape expected) const {
  const CheckedSet of = open_checked(name, unit, expected, H5T_INTEGER, "integers");
  const hid_t own = sizeof(T) == 1 ? H5T_NATIVE_INT8 : H5T_NATIVE_INT32;
  if (H5Tequal(of.type.id(), own) > 0) return values<T>(of, name, own);
  std::vector<T> out;
  for (const std::int64_t wide : values<std::int64_t>(of, name, H5T_NATIVE_INT64)) {
    out.push_back(static_cast<T>(wide));
    if (out.back() != wide)
      throw error(name, fmt::format("row {} is beyond {} bits", out.size() - 1, 8 * sizeof(T)));
  }
  return out;
}

template std::vector<std::int32_t> Reader::integers(const std::string&, std::string_view,
                                                    Shape) const;
template std::vector<std::int8_t> Reader::integers(const std::string&, std::string_view,
                                                   Shape) const;

std::vector<std::string> Reader::strings(const std::string& name, std::size_t rows) const {
  const auto [set, type, shape] = open_checked(name, kAnyUnit, {rows, 0}, H5T_STRING, "text");
  const Handle space(H5Dget_space(set.id()), H5Sclose);
  std::vector<std::string> values;
  const auto read = [&set = set](hid_t memory_type, void* data) {
    return H5Dread(set.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  };
  if (shape.rows > 0 && !read_strings(type, space, shape.rows, read, values))
    throw error(name, "cannot be read (HDF5: " + take_reason() + ")");
  return values;
}

bool Reader::has_attribute(const std::string& object, const std::string& name) const {
  return H5Aexists(open_object(object).id(), name.c_str()) > 0;
}

Reader::OpenAttribute Reader::open_attribute(const std::string& object,
                                             const std::string& name) const {
  const Handle owner = open_object(object);
  if (H5Aexists(owner.id(), name.c_str()) <= 0) throw attribute_error(object, name, "is missing");
  Handle attribute(H5Aopen(owner.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.is_valid()) throw attribute_error(object, name, "cannot be opened");
  Handle type(H5Aget_type(attribute.id()), H5Tclose);
  Handle space(H5Aget_space(attribute.id()), H5Sclose);
  return {std::move(attribute), std::move(type), std::move(space)};
}

std::vector<std::string> Reader::texts_attribute(const std::string& object,
                                                 const std::string& name) const {
  const auto [attribute, type, space] = open_attribute(object, name);
  if (H5Tget_class(type.id()) != H5T_STRING) throw attribute_error(object, name, "is not text");
  const hssize_t count = H5Sget_simple_extent_npoints(space.id());
  if (count < 0 || static_cast<std::uintmax_t>(count) * H5Tget_size(type.id()) > file_bytes_)
    throw attribute_error(object, name, "claims more bytes than the file has");
  std::vector<std::string> values;
  const auto read = [&id = attribute](hid_t memory_type, void* data) {
    return H5Aread(id.id(), memory_type, data);
  };
  if (!read_strings(type, space, static_cast<std::size_t>(count), read, values))
    throw attribute_error(object, name, "cannot be read");
  return values;
}

std::string Reader::text_attribute(const std::string& object, const std::string& name) const {
  const auto values = texts_attribute(object, name);
  if (values.size() != 1) throw attribute_error(object, name, "is not a single text");
  return values.front();
}

std::string Reader::text_if_any(const std::string& object, const std::string& name) const {
  return has_attribute(object, name) ? text_attribute(object, name) : "";
}

std::int64_t Reader::integer_attribute(const std::string& object, const std::string& name) const {
  const auto [attribute, type, space] = open_attribute(object, name);
  std::int64_t value = 0;
  if (H5Tget_class(type.id()) != H5T_INTEGER || H5Sget_simple_extent_npoints(space.id()) != 1 ||
      H5Aread(attribute.id(), H5T_NATIVE_INT64, &value) < 0)
    throw attribute_error(object, name, "is not one integer");
  return value;
}

Attributes Reader::root_texts() const {
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  hsize_t at = 0;
  if (H5Aiterate2(file_.id(), H5_INDEX_NAME, H5_ITER_INC, &at, collect, &names) < 0)
    throw error("", "attributes cannot be listed (HDF5: " + take_reason() + ")");
  Attributes texts;
  for (const auto& name : names) {
    const auto [attribute, type, space] = open_attribute("", name);
    if (H5Tget_class(type.id()) == H5T_STRING && H5Sget_simple_extent_npoints(space.id()) == 1)
      texts[name] = text_attribute("", name);
  }
  return texts;
}

std::vector<std::string> Reader::data_sets() const {
  std::vector<std::string> names;
  // The structure that H5Ovisit2 hands on is H5O_info_t in HDF5 1.10 and H5O_info1_t since 1.12.
  const auto collect = [](hid_t, const char* name, const auto* info, void* out) -> herr_t {
    if (info->type == H5O_TYPE_DATASET)
      static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  if (H5Ovisit2(file_.id(), H5_INDEX_NAME, H5_ITER_INC, collect, &names, H5O_INFO_BASIC) < 0)
    throw error("", "data sets cannot be listed (HDF5: " + take_reason() + ")");
  std::sort(names.begin(), names.end());
  return names;
}

std::string Reader::type_of(const std::string& name) const {
  const Handle set = open_data_set(name);
  const Handle type(H5Dget_type(set.id()), H5Tclose);
  const std::size_t bits = 8 * H5Tget_size(type.id());
  switch (H5Tget_class(type.id())) {
    case H5T_FLOAT:
      return fmt::format("float{}", bits);
    case H5T_INTEGER:
      return fmt::format("{}{}", H5Tget_sign(type.id()) == H5T_SGN_NONE ? "uint" : "int", bits);
    case H5T_STRING:
      return "text";
    default:
      return "another type";
  }
}

}  // namespace palpate::h5
