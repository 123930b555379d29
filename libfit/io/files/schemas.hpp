#pragma once

#include <array>
#include <string_view>

namespace palpate {

/// One kind of HDF5 file: what its root attributes say and which command makes it.
/// version rises when a file that an older reader takes would be misread; added optional data sets
/// do not raise it.
struct FileSchema {
  std::string_view name;
  int version;
  std::string_view remedy;
};

inline constexpr FileSchema kBodySchema{"palpate-body", 1, "Make it again with `palpate prepare`."};
inline constexpr FileSchema kSamplesSchema{
    "palpate-samples", 1, "Make it again with `palpate simulate` or `palpate import`."};
inline constexpr FileSchema kCurvesSchema{"palpate-curves", 1, "Make it again with `palpate fit`."};
inline constexpr FileSchema kModelSchema{"palpate-model", 1,
                                         "Make it again with `palpate refine`."};

inline constexpr std::array kFileSchemas{kBodySchema, kSamplesSchema, kCurvesSchema, kModelSchema};

}  // namespace palpate
