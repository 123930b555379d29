#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

struct DataSetDescription {
  std::string name;  ///< "rows/force"
  std::string type;  ///< "float64", "int32", "text", ...
  h5::Shape shape;
  std::string unit;  ///< empty when the file has none
};

/// What an HDF5 file says about itself, without its values.
struct FileDescription {
  std::string schema;  ///< "palpate-samples", ...
  int version = 0;
  Attributes attributes;  ///< named strings, `schema` left out
  std::vector<DataSetDescription> data_sets;
};

/// Schema of a Palpate HDF5 file, "palpate-samples" for instance (kFileSchemas has all).
/// Throws Error when it is no HDF5 file or not one of ours.
std::string schema_of(const std::filesystem::path& path);

/// Contents of a Palpate HDF5 file for `palpate inspect`. Reads no values.
FileDescription describe(const std::filesystem::path& path);

/// The named strings a file was written with (`inputs_hash`, ...). Throws as schema_of does.
Attributes read_attributes(const std::filesystem::path& path);

}  // namespace palpate
