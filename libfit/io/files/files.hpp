#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

// Readers throw Error on missing or malformed columns, indices out of range, numbers that are not
// finite and normals that are not unit vectors. Writers store a file whole or not at all, and
// refuse what its reader would refuse.

/// The body of a body.h5 (docs/formats/body.md).
Body read_body(const std::filesystem::path& path);
void write_body(const std::filesystem::path& path, const Body& body,
                const Attributes& attributes = {});

/// Experiments of a samples.h5 (docs/formats/samples.md), simulated, measured or made by others.
/// force and torque may be NaN in rows whose status is not `good`, force_error anywhere.
Samples read_samples(const std::filesystem::path& path);
void write_samples(const std::filesystem::path& path, const Samples& samples,
                   const Attributes& attributes = {});

/// Names of the files beside samples.h5: the motion of the surface (samples.surface.h5) and the
/// signals of the recordings (samples.signals.h5).
std::filesystem::path surface_path(std::filesystem::path samples_path);
std::filesystem::path signals_path(std::filesystem::path samples_path);

/// Reads the motion of the surface of these samples into samples.surface. Throws Error where its
/// rows are not those of the samples.
void read_surface_motion(const std::filesystem::path& path, Samples& samples);
void write_surface_motion(const std::filesystem::path& path, const Samples& samples,
                          const Attributes& attributes = {});

inline constexpr std::array<std::string_view, 4> kFitStatusNames{"good", "underdetermined", "poor",
                                                                 "failed"};

/// Fitted curves of a curves.h5 (docs/formats/curves.md). Refuses curves that fall, do not start at
/// 0 or are not exact in float32. Residuals may be NaN.
FittedCurves read_curves(const std::filesystem::path& path);
void write_curves(const std::filesystem::path& path, const FittedCurves& curves,
                  const Attributes& attributes = {});

/// The refined model of a model.h5 (docs/formats/model.md). Refuses curves that fall or are not
/// exact in float32, and weights that are negative or do not sum to 1 (0 where not covered) within
/// 1e-12.
Model read_model(const std::filesystem::path& path);
void write_model(const std::filesystem::path& path, const Model& model,
                 const Attributes& attributes = {});

/// One kind of HDF5 file: what its root attribute `schema` says and which command makes it.
struct FileSchema {
  std::string_view name;
  std::string_view remedy;
};

inline constexpr FileSchema kBodySchema{"palpate-body", "Make it again with `palpate prepare`."};
inline constexpr FileSchema kSamplesSchema{
    "palpate-samples", "Make it again with `palpate simulate` or `palpate import`."};
inline constexpr FileSchema kSurfaceSchema{"palpate-surface",
                                           "Delete it and run `palpate simulate` again."};
inline constexpr FileSchema kCurvesSchema{"palpate-curves", "Make it again with `palpate fit`."};
inline constexpr FileSchema kModelSchema{"palpate-model", "Make it again with `palpate refine`."};

inline constexpr std::array kFileSchemas{kBodySchema, kSamplesSchema, kSurfaceSchema, kCurvesSchema,
                                         kModelSchema};

inline constexpr FileSchema kSignalsSchema{"palpate-signals",
                                           "Make it again with `palpate import`."};

/// Recordings as they came, for pictures (docs/formats/samples.md).
RecordedSignals read_signals(const std::filesystem::path& path);
void write_signals(const std::filesystem::path& path, const RecordedSignals& signals,
                   const Attributes& attributes = {});

struct DataSetDescription {
  std::string name;  ///< "rows/force"
  std::string type;  ///< "float64", "int32", "text", ...
  h5::Shape shape;
  std::string unit;  ///< empty when the file has none
};

/// Description of an HDF5 file without its values.
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
