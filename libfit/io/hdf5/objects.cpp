#include <fmt/core.h>

#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <type_traits>

#include "libfit/io/hdf5/hdf5.hpp"

// Handles, texts, attributes, and what a file holds; values are read in read.cpp.

namespace palpate::h5 {

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

/// Fetches all values as a memory type into a buffer, negative on failure.
using ReadValues = std::function<int(std::int64_t memory_type, void* buffer)>;

std::string trimmed(const char* field, std::size_t size, bool is_space_padded) {
  std::size_t length = ::strnlen(field, size);
  while (is_space_padded && length > 0 && field[length - 1] == ' ') --length;
  return std::string(field, length);
}

bool read_variable(const Handle& type, const Handle& space, std::size_t count,
                   const ReadValues& read, std::vector<std::string>& out) {
  std::vector<char*> texts(count, nullptr);
  if (read(type.id(), texts.data()) < 0) return false;
  for (const char* text : texts) out.emplace_back(text != nullptr ? text : "");
  H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, texts.data());
  return true;
}

bool read_fixed(const Handle& type, std::size_t count, const ReadValues& read,
                std::vector<std::string>& out) {
  const std::size_t size = H5Tget_size(type.id());
  std::vector<char> packed(count * size);
  if (read(type.id(), packed.data()) < 0) return false;
  const bool is_space_padded = H5Tget_strpad(type.id()) == H5T_STR_SPACEPAD;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(trimmed(packed.data() + i * size, size, is_space_padded));
  return true;
}

// Appends `count` texts of fixed or variable length, without their padding. The file's own type is
// the memory type: HDF5 does not convert between character sets.
bool read_strings(const Handle& type, const Handle& space, std::size_t count,
                  const ReadValues& read, std::vector<std::string>& out) {
  return H5Tis_variable_str(type.id()) > 0 ? read_variable(type, space, count, read, out)
                                           : read_fixed(type, count, read, out);
}

}  // namespace

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

Error Reader::attribute_error(const std::string& object, const std::string& name,
                              const std::string& what) const {
  return error(object, "attribute `" + name + "` " + what);
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
