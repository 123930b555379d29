#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/io/files/describe.hpp"
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

}  // namespace palpate::h5
