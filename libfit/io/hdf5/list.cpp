#include <hdf5.h>

#include <algorithm>

#include "libfit/io/hdf5/hdf5.hpp"

// What a file holds, without reading values: for `palpate inspect` and for provenance.

namespace palpate::h5 {

std::vector<std::string> Reader::data_sets() const {
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5O_info_t* info, void* out) -> herr_t {
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
  const std::string bits = std::to_string(8 * H5Tget_size(type.id()));
  switch (H5Tget_class(type.id())) {
    case H5T_FLOAT:
      return "float" + bits;
    case H5T_INTEGER:
      return (H5Tget_sign(type.id()) == H5T_SGN_NONE ? "uint" : "int") + bits;
    case H5T_STRING:
      return "text";
    default:
      return "another type";
  }
}

}  // namespace palpate::h5
