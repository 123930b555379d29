#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

// Between the plain data of libfit/core and the columns of an HDF5 file, for this layer alone.
// Rows and columns come as in the struct; every refusal is an Error that names the data set.

namespace palpate::h5 {

/// Error about one data set: of the file read, or of the data a caller asks to write.
using Complain = std::function<Error(const std::string& data_set, const std::string& what)>;
Complain complain_about(const Reader& reader);
Complain complain_about(const std::filesystem::path& path);

/// A file of this schema, opened and checked.
Reader open(const std::filesystem::path& path, const FileSchema& schema);
Writer create(const std::filesystem::path& path, const FileSchema& schema,
              const Attributes& attributes);

/// rows: expected, or kAny.
Points read_points(const Reader& reader, const std::string& name, std::string_view unit,
                   std::size_t rows, bool may_be_nan = false);
Eigen::VectorXd read_vector(const Reader& reader, const std::string& name, std::string_view unit,
                            std::size_t rows, bool may_be_nan = false);
Triangles read_triangles(const Reader& reader, const std::string& name, std::size_t rows);
/// rows x columns numbers.
Controls read_table(const Reader& reader, const std::string& name, std::string_view unit,
                    Eigen::Index rows, Eigen::Index columns, bool may_be_nan = false);
std::vector<char> read_flags(const Reader& reader, const std::string& name, std::size_t rows);

/// Codes of an enumeration, 0 on, by the names that the file lists for them, else by `names`.
std::vector<int> read_code_numbers(const Reader& reader, const std::string& column,
                                   std::size_t rows, std::span<const std::string_view> names);
void write_code_numbers(Writer& writer, const std::string& column,
                        std::span<const std::int8_t> codes,
                        std::span<const std::string_view> names);
template <class Enum>
std::vector<Enum> read_codes(const Reader& reader, const std::string& column, std::size_t rows,
                             std::span<const std::string_view> names) {
  std::vector<Enum> out;
  for (const int code : read_code_numbers(reader, column, rows, names))
    out.push_back(static_cast<Enum>(code));
  return out;
}
template <class Enum>
void write_codes(Writer& writer, const std::string& column, const std::vector<Enum>& values,
                 std::span<const std::string_view> names) {
  std::vector<std::int8_t> codes;
  for (const Enum value : values) codes.push_back(static_cast<std::int8_t>(value));
  write_code_numbers(writer, column, codes, names);
}

void write_points(Writer& writer, const std::string& name, std::string_view unit,
                  const Points& points);
void write_vector(Writer& writer, const std::string& name, std::string_view unit,
                  const Eigen::VectorXd& values);
void write_table(Writer& writer, const std::string& name, std::string_view unit,
                 const Controls& values);
void write_triangles(Writer& writer, const std::string& name, const Triangles& triangles);
void write_flags(Writer& writer, const std::string& name, const std::vector<char>& flags);

/// Checks shared by readers and writers; they throw what `complain` makes.
void check_rows(const Complain& complain, const std::string& name, Eigen::Index found,
                Eigen::Index expected);
void check_finite(const Complain& complain, const std::string& name, const Points& points);
/// Every row has length 1 within 1e-6 (float32 sources pass).
void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors);
/// Every index in [0, end).
void check_indices(const Complain& complain, const std::string& name, const std::int32_t* indices,
                   Eigen::Index rows, Eigen::Index columns, Eigen::Index end);
void check_flags(const Complain& complain, const std::string& name, const std::vector<char>& flags,
                 Eigen::Index rows);

/// The group `probe` of a file (docs/formats.md): shape, friction, the shape's numbers with their
/// units, orientation and heading, mesh. Nothing where the file has none. Throws Error on numbers
/// that are not finite, a negative friction, triangles without vertices.
std::optional<ProbeSpec> read_probe(const Reader& reader);

/// Writes no group without a probe. Refuses what read_probe would refuse.
void write_probe(Writer& writer, const std::optional<ProbeSpec>& probe, const Complain& complain);

/// The parts of the family that the root attribute `family` names, each under curves/NAME: controls
/// (in the part's unit, a row per point) and, of a curve, knots (m) and the attribute `degree`.
/// Throws Error when the family is unknown.
CurveSet read_curve_set(const Reader& reader, std::size_t points);
void write_curve_set(Writer& writer, const CurveSet& curves);

/// Bases can be tabulated; every row of a part has the basis's size, is finite, held exactly by
/// float32, within the part's bounds, starts at 0 and never falls where the part says so.
void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points);

/// The same of one part's numbers under `name`, of P = points rows.
void check_controls(const Complain& complain, const std::string& name, const runtime::Part& part,
                    const Controls& controls, const CurveBasis& basis, Eigen::Index points);

}  // namespace palpate::h5
