#include <hdf5.h>

#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/io/hdf5/strings.hpp"

namespace palpate::h5 {

Error Reader::attribute_error(const std::string& object, const std::string& name,
                              const std::string& what) const {
  return error(object, "attribute `" + name + "` " + what);
}

bool Reader::has_attribute(const std::string& object, const std::string& name) const {
  return H5Aexists(open_object(object).id(), name.c_str()) > 0;
}

Handle Reader::open_attribute(const std::string& object, const std::string& name) const {
  const Handle owner = open_object(object);
  if (H5Aexists(owner.id(), name.c_str()) <= 0) throw attribute_error(object, name, "is missing");
  Handle attribute(H5Aopen(owner.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.is_valid()) throw attribute_error(object, name, "cannot be opened");
  return attribute;
}

std::vector<std::string> Reader::texts_attribute(const std::string& object,
                                                 const std::string& name) const {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute.id()), H5Tclose);
  const Handle space(H5Aget_space(attribute.id()), H5Sclose);
  if (H5Tget_class(type.id()) != H5T_STRING) throw attribute_error(object, name, "is not text");
  const hssize_t count = H5Sget_simple_extent_npoints(space.id());
  if (count < 0 || static_cast<std::uintmax_t>(count) * H5Tget_size(type.id()) > file_bytes_)
    throw attribute_error(object, name, "claims more bytes than the file has");
  std::vector<std::string> values;
  const auto read = [&](hid_t memory_type, void* data) {
    return H5Aread(attribute.id(), memory_type, data);
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

std::int64_t Reader::integer_attribute(const std::string& object, const std::string& name) const {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute.id()), H5Tclose);
  const Handle space(H5Aget_space(attribute.id()), H5Sclose);
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
    const Handle attribute = open_attribute("", name);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const Handle space(H5Aget_space(attribute.id()), H5Sclose);
    if (H5Tget_class(type.id()) == H5T_STRING && H5Sget_simple_extent_npoints(space.id()) == 1)
      texts[name] = text_attribute("", name);
  }
  return texts;
}

}  // namespace palpate::h5
