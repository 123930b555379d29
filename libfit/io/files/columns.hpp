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
#include "libfit/core/samples.hpp"
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

/// Codes of an enumeration, 0 on, by the names that the file lists for them, else by `names`.
std::vector<int> read_codes(const Reader& reader, const std::string& column, std::size_t rows,
                            std::span<const std::string_view> names);

template <class Column>
Eigen::Index rows_of(const Column& column) {
  if constexpr (requires { column.rows(); })
    return column.rows();
  else
    return static_cast<Eigen::Index>(column.size());
}

// A file's columns are listed once, as calls f(name, column, kept) and, for the first column of
// those with one number of rows, f.first(name, column, kept): false where the group is missing.
// These read, write and check them.

class ColumnReader {
 public:
  explicit ColumnReader(const Reader& in, std::size_t rows = kAny) : in_(in), rows_(rows) {}

  template <class Column>
  bool first(const std::string& name, Column& column, const ColumnFormat& kept = {}) {
    rows_ = kAny;
    (*this)(name, column, kept);
    rows_ = static_cast<std::size_t>(rows_of(column));
    return !kept.is_optional || in_.has(name);
  }
  template <class Column>
  void operator()(const std::string& name, Column& column, const ColumnFormat& kept = {}) const {
    if (!kept.is_optional || in_.has(name)) get(name, column, kept);
  }

 private:
  template <class Matrix>
  requires requires { Matrix::ColsAtCompileTime; }
  void get(const std::string& name, Matrix& out, const ColumnFormat& kept) const {
    constexpr int kColumns = Matrix::ColsAtCompileTime;
    using Scalar =
        std::conditional_t<std::is_floating_point_v<typename Matrix::Scalar>, double, std::int32_t>;
    const std::size_t wanted = kColumns == 1 ? 0 : kColumns == Eigen::Dynamic ? kAny : kColumns;
    const Shape shape{rows_, wanted};
    const auto fill = [&](const std::vector<Scalar>& values) {
      const Eigen::Index columns =
          kColumns == Eigen::Dynamic ? in_.shape_of(name).columns : kColumns;
      const Eigen::Index rows = columns == 0 ? 0 : values.size() / columns;
      constexpr int kOrder = kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor;
      using Values = Eigen::Matrix<Scalar, Eigen::Dynamic, kColumns, kOrder>;
      out = Eigen::Map<const Values>(values.data(), rows, columns)
                .template cast<typename Matrix::Scalar>();
    };
    if constexpr (std::is_same_v<Scalar, double>)
      fill(in_.numbers(name, kept.unit, shape, kept.may_be_nan));
    else
      fill(in_.integers(name, kept.unit, shape));
  }
  void get(const std::string& name, std::vector<std::string>& out, const ColumnFormat&) const {
    out = in_.strings(name, rows_);
  }
  void get(const std::string& name, std::vector<double>& out, const ColumnFormat& kept) const {
    out = in_.numbers(name, kept.unit, {rows_, 0}, kept.may_be_nan);
  }
  void get(const std::string& name, std::vector<std::int32_t>& out,
           const ColumnFormat& kept) const {
    out = in_.integers(name, kept.unit, {rows_, 0});
  }
  void get(const std::string& name, std::vector<char>& out, const ColumnFormat& kept) const {
    const auto values = in_.integers<std::int8_t>(name, kept.unit, {rows_, 0});
    out.assign(values.begin(), values.end());
  }
  template <class Code>
  void get(const std::string& name, std::vector<Code>& out, const ColumnFormat& kept) const {
    out.clear();
    for (const int code : read_codes(in_, name, rows_, kept.names))
      out.push_back(static_cast<Code>(code));
  }

  const Reader& in_;
  std::size_t rows_;
};

class ColumnWriter {
 public:
  explicit ColumnWriter(Writer& out) : out_(out) {}

  template <class Column>
  bool first(const std::string& name, const Column& column, const ColumnFormat& kept = {}) {
    (*this)(name, column, kept);
    return !kept.is_optional || rows_of(column) > 0;
  }
  template <class Column>
  void operator()(const std::string& name, const Column& column, const ColumnFormat& kept = {}) {
    if (kept.is_optional && column.size() == 0) return;
    put(name, column, kept);
    if (!kept.names.empty())
      out_.attribute(name, "names", std::vector<std::string>(kept.names.begin(), kept.names.end()));
  }

 private:
  template <class Column>
  void put(const std::string& name, const Column& column, const ColumnFormat& kept) {
    const auto rows = static_cast<std::size_t>(rows_of(column));
    if constexpr (requires { Column::ColsAtCompileTime; }) {
      const std::size_t columns = Column::ColsAtCompileTime == 1 ? 0 : column.cols();
      const Shape shape{rows, columns};
      if constexpr (std::is_same_v<typename Column::Scalar, double>)
        out_.numbers(name, kept.unit, column.data(), shape);
      else if constexpr (std::is_same_v<typename Column::Scalar, float>)
        out_.numbers(name, kept.unit, Controls(column.template cast<double>()).data(), shape);
      else
        out_.integers(name, kept.unit, column.data(), shape);
    } else if constexpr (std::is_same_v<Column, std::vector<std::string>>) {
      out_.strings(name, column);
    } else if constexpr (std::is_same_v<Column, std::vector<double>>) {
      out_.numbers(name, kept.unit, column.data(), {rows, 0});
    } else if constexpr (std::is_same_v<Column, std::vector<std::int32_t>>) {
      out_.integers(name, kept.unit, column.data(), {rows, 0});
    } else {  // codes and flags
      std::vector<std::int8_t> codes;
      for (const auto code : column) codes.push_back(static_cast<std::int8_t>(code));
      out_.bytes(name, kept.unit, codes.data(), {rows, 0});
    }
  }

  Writer& out_;
};

/// Checks shared by readers and writers; they throw what `complain` makes.
void check_rows(const Complain& complain, const std::string& name, Eigen::Index found,
                Eigen::Index expected);
/// Every value finite, or NaN where that is let through; rows of `width` values.
void check_finite(const Complain& complain, const std::string& name, const double* values,
                  Eigen::Index count, Eigen::Index width, bool may_be_nan);
void check_flags(const Complain& complain, const std::string& name, const std::vector<char>& flags);

/// Refuses columns with other rows than the first of their group, numbers that are not finite and
/// flags that are neither 0 nor 1.
class ColumnChecker {
 public:
  explicit ColumnChecker(const Complain& complain) : complain_(complain) {}

  template <class Column>
  bool first(const std::string& name, const Column& column, const ColumnFormat& kept = {}) {
    rows_ = rows_of(column);
    (*this)(name, column, kept);
    return true;
  }
  template <class Column>
  void operator()(const std::string& name, const Column& column,
                  const ColumnFormat& kept = {}) const {
    if (!kept.is_optional || rows_of(column) > 0)
      check_rows(complain_, name, rows_of(column), rows_);
    if constexpr (std::is_same_v<Column, std::vector<char>>)
      check_flags(complain_, name, column);
    else if constexpr (std::is_same_v<Column, std::vector<double>>)
      check_finite(complain_, name, column.data(), rows_, 1, kept.may_be_nan);
    else if constexpr (requires { requires std::is_same_v<typename Column::Scalar, double>; })
      check_finite(complain_, name, column.data(), column.size(), column.cols(), kept.may_be_nan);
  }

 private:
  const Complain& complain_;
  Eigen::Index rows_ = 0;
};

/// Every row has length 1 within 1e-6 (float32 sources pass), or 0 where that is let through.
void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors,
                       bool may_be_zero = false);
/// Every index in [0, end), of a matrix or a vector.
template <class Column>
void check_indices(const Complain& complain, const std::string& name, const Column& column,
                   Eigen::Index end) {
  for (Eigen::Index i = 0; i < std::ssize(column); ++i)
    if (const std::int32_t index = column.data()[i]; index < 0 || index >= end)
      throw complain(name, "row " + std::to_string(i * rows_of(column) / std::ssize(column)) +
                               " holds index " + std::to_string(index) + ", not 0.." +
                               std::to_string(end - 1));
}

/// The group `probe` of a file (docs/formats.md): shape, friction, the shape's numbers with their
/// units, orientation, mesh. Nothing where the file has none. Throws Error on numbers
/// that are not finite, a negative friction, triangles without vertices.
std::optional<ProbeSpec> read_probe(const Reader& reader, const std::string& group = "probe/");

/// Writes no group without a probe. Refuses what read_probe would refuse.
void write_probe(Writer& writer, const std::optional<ProbeSpec>& probe, const Complain& complain,
                 const std::string& group = "probe/");

/// The parts of the family that the root attribute `family` names, each under curves/NAME: controls
/// (in the part's unit, a row per point) and, of a curve, knots (m) and the attribute `degree`.
/// Throws Error when the family is unknown.
CurveSet read_curve_set(const Reader& reader, std::size_t points);
void write_curve_set(Writer& writer, const CurveSet& curves);

/// Bases can be tabulated; every row of a part has the basis's size, is finite, held exactly by
/// float32, within the part's bounds, starts at 0 and never falls where the part says so.
void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points);

/// Columns of a Relaxation, R: Relaxation or const Relaxation; none where a body has none.
template <class R, class F>
void relaxation_columns(R& relaxation, F& f) {
  if (!f.first("relaxation/share", relaxation.share, {.is_optional = true})) return;
  f("relaxation/time", relaxation.time_s, {.unit = "s"});
}
void check_relaxation(const Complain& complain, const Relaxation& relaxation);

}  // namespace palpate::h5
