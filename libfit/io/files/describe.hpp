#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

/// One kind of HDF5 file: what its root attributes say and which command makes it.
/// version rises when a file of an older version would be misread; added optional data sets do not
/// raise it.
struct FileSchema {
  std::string_view name;
  int version;
  std::string_view remedy;
};

inline constexpr FileSchema kBodySchema{"palpate-body", 1, "Make it again with `palpate prepare`."};
inline constexpr FileSchema kSamplesSchema{
    "palpate-samples", 1, "Make it again with `palpate simulate` or `palpate import`."};
inline constexpr FileSchema kCurvesSchema{"palpate-curves", 1, "Make it again with `palpate fit`."};
inline constexpr FileSchema kFitCacheSchema{"palpate-fit-cache", 1,
                                            "Delete it: it saves time only."};
inline constexpr FileSchema kModelSchema{"palpate-model", 1,
                                         "Make it again with `palpate refine`."};

inline constexpr std::array kFileSchemas{kBodySchema, kSamplesSchema, kCurvesSchema,
                                         kFitCacheSchema, kModelSchema};

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
