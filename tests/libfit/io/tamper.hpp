#pragma once

#include <hdf5.h>

#include <filesystem>
#include <string>
#include <vector>

// What a careless or hostile writer does to an HDF5 file: the tests' own hand on the C API.
namespace palpate::testing_io {

class Tamper {
 public:
  explicit Tamper(const std::filesystem::path& path)
      : file_(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)) {}
  ~Tamper() { H5Fclose(file_); }

  void remove(const std::string& name) { H5Ldelete(file_, name.c_str(), H5P_DEFAULT); }
  void remove_attribute(const std::string& object, const std::string& name) {
    H5Adelete_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT);
  }
  void set_text(const std::string& object, const std::string& name, const std::string& value) {
    const hid_t type = H5Tcopy(H5T_C_S1);  // variable length, as h5py writes
    H5Tset_size(type, H5T_VARIABLE);
    const char* text = value.c_str();
    set(object, name, type, &text);
    H5Tclose(type);
  }
  void set_integer(const std::string& object, const std::string& name, long long value) {
    set(object, name, H5T_NATIVE_LLONG, &value);
  }
  /// Replaces a data set by one of float32, or of another type, rows x columns (0: one dimension).
  template <class T>
  void replace(const std::string& name, const std::string& unit, hid_t file_type, hid_t memory_type,
               const std::vector<T>& values, hsize_t columns) {
    remove(name);
    const hsize_t dims[2] = {columns == 0 ? values.size() : values.size() / columns, columns};
    const hid_t space = H5Screate_simple(columns == 0 ? 1 : 2, dims, nullptr);
    const hid_t set =
        H5Dcreate2(file_, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
    H5Sclose(space);
    set_text(name, "unit", unit);
  }
  /// Overwrites one value of a data set in place.
  void poke(const std::string& name, std::size_t index, double value) {
    const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(set);
    std::vector<double> values(H5Sget_simple_extent_npoints(space));
    H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    values.at(index) = value;
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Sclose(space);
    H5Dclose(set);
  }
  /// A data set of the right look whose values were never written, or live in another file.
  void hollow(const std::string& name, const std::string& unit, hsize_t rows,
              const char* external = nullptr) {
    remove(name);
    const hsize_t dims[2] = {rows, 3};
    const hid_t space = H5Screate_simple(2, dims, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (external != nullptr) H5Pset_external(creation, external, 0, rows * 24);
    const hid_t set =
        H5Dcreate2(file_, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    H5Dclose(set);
    H5Pclose(creation);
    H5Sclose(space);
    set_text(name, "unit", unit);
  }
  void link_elsewhere(const std::string& name, const char* target) {
    remove(name);
    H5Lcreate_soft(target, file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
  }

 private:
  void set(const std::string& object, const std::string& name, hid_t type, const void* value) {
    if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0)
      remove_attribute(object, name);
    const hid_t scalar = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, scalar,
                                              H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, value);
    H5Aclose(attribute);
    H5Sclose(scalar);
  }

  hid_t file_;
};

}  // namespace palpate::testing_io
