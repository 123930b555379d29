#include "libfit/io/files/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate::h5 {
namespace {

Shape shape_of_matrix(Eigen::Index rows, Eigen::Index columns) {
  return {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)};
}

constexpr double kUnitLengthTolerance = 1e-6;

}  // namespace

Complain complain_about(const Reader& reader) {
  return [&reader](const std::string& name, const std::string& what) {
    return reader.error(name, what);
  };
}

Complain complain_about(const std::filesystem::path& path) {
  return [path](const std::string& name, const std::string& what) {
    return Error(path.string() + ":" + name, what, "Not written; report how it was made.");
  };
}

Reader open(const std::filesystem::path& path, const FileSchema& schema) {
  Reader reader(path, std::string(schema.remedy));
  reader.expect(schema.name, schema.version);
  return reader;
}

Writer create(const std::filesystem::path& path, const FileSchema& schema,
              const Attributes& attributes) {
  for (const std::string reserved : {"schema", "version", "family"})
    if (attributes.count(reserved) != 0)
      throw Error(path.string(), "attribute `" + reserved + "` is the file's own",
                  "Name it otherwise.");
  return Writer(path, schema.name, schema.version, attributes);
}

Points read_points(const Reader& reader, const std::string& name, std::string_view unit,
                   std::size_t rows, bool may_be_nan) {
  const auto values = reader.numbers(name, unit, {rows, 3}, may_be_nan);
  return Eigen::Map<const Points>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3);
}

Eigen::VectorXd read_vector(const Reader& reader, const std::string& name, std::string_view unit,
                            std::size_t rows, bool may_be_nan) {
  const auto values = reader.numbers(name, unit, {rows, 0}, may_be_nan);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Controls read_table(const Reader& reader, const std::string& name, std::string_view unit,
                    Eigen::Index rows, Eigen::Index columns, bool may_be_nan) {
  const auto values = reader.numbers(
      name, unit, {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)}, may_be_nan);
  return Eigen::Map<const Controls>(values.data(), rows, columns);
}

Triangles read_triangles(const Reader& reader, const std::string& name, std::size_t rows) {
  const auto values = reader.integers(name, kNoUnit, {rows, 3});
  return Eigen::Map<const Triangles>(values.data(), static_cast<Eigen::Index>(values.size() / 3),
                                     3);
}

std::vector<char> read_flags(const Reader& reader, const std::string& name, std::size_t rows) {
  const auto values = reader.bytes(name, kNoUnit, {rows, 0});
  return {values.begin(), values.end()};
}

void write_points(Writer& writer, const std::string& name, std::string_view unit,
                  const Points& points) {
  writer.numbers(name, unit, points.data(), shape_of_matrix(points.rows(), 3));
}

void write_vector(Writer& writer, const std::string& name, std::string_view unit,
                  const Eigen::VectorXd& values) {
  writer.numbers(name, unit, values.data(), shape_of_matrix(values.size(), 0));
}

void write_table(Writer& writer, const std::string& name, std::string_view unit,
                 const Controls& values) {
  writer.numbers(name, unit, values.data(), shape_of_matrix(values.rows(), values.cols()));
}

void write_triangles(Writer& writer, const std::string& name, const Triangles& triangles) {
  writer.integers(name, kNoUnit, triangles.data(), shape_of_matrix(triangles.rows(), 3));
}

void write_flags(Writer& writer, const std::string& name, const std::vector<char>& flags) {
  const std::vector<std::int8_t> values(flags.begin(), flags.end());
  writer.bytes(name, kNoUnit, values.data(), {values.size(), 0});
}

void check_rows(const Complain& complain, const std::string& name, Eigen::Index found,
                Eigen::Index expected) {
  if (found != expected) throw complain(name, fmt::format("has {} rows, not {}", found, expected));
}

void check_finite(const Complain& complain, const std::string& name, const Points& points) {
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw complain(name, fmt::format("row {} is not a finite number", i));
}

void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors) {
  for (Eigen::Index i = 0; i < vectors.rows(); ++i)
    if (!(std::abs(vectors.row(i).norm() - 1) < kUnitLengthTolerance))
      throw complain(name, fmt::format("row {} is not a unit vector", i));
}

void check_indices(const Complain& complain, const std::string& name, const std::int32_t* indices,
                   Eigen::Index rows, Eigen::Index columns, Eigen::Index end) {
  for (Eigen::Index i = 0; i < rows * columns; ++i)
    if (indices[i] < 0 || indices[i] >= end)
      throw complain(
          name, fmt::format("row {} holds index {}, not 0..{}", i / columns, indices[i], end - 1));
}

void check_flags(const Complain& complain, const std::string& name, const std::vector<char>& flags,
                 Eigen::Index rows) {
  check_rows(complain, name, static_cast<Eigen::Index>(flags.size()), rows);
  const auto bad =
      std::find_if(flags.begin(), flags.end(), [](char f) { return f != 0 && f != 1; });
  if (bad != flags.end())
    throw complain(name, fmt::format("row {} is neither 0 nor 1", bad - flags.begin()));
}

}  // namespace palpate::h5
