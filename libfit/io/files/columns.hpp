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

/// Codes of an enumeration, 0 on, by the names that the file lists for them, else by `names`.
std::vector<int> read_codes(const Reader& reader, const std::string& column, std::size_t rows,
                            std::span<const std::string_view> names);

/// rows x columns numbers.
Controls read_table(const Reader& reader, const std::string& name, std::string_view unit,
                    Eigen::Index rows, Eigen::Index columns, bool may_be_nan = false);
void write_table(Writer& writer, const std::string& name, std::string_view unit,
                 const Controls& values);

/// How a column is kept. names: of its codes. is_optional: without rows it is not written.
struct Kept {
  std::string_view unit = kNoUnit;
  bool may_be_nan = false;
  std::span<const std::string_view> names = {};
  bool is_optional = false;
};

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
  explicit ColumnReader(const Reader& in) : in_(in) {}

  template <class Column>
  bool first(const std::string& name, Column& column, const Kept& kept = {}) {
    rows_ = kAny;
    (*this)(name, column, kept);
    rows_ = static_cast<std::size_t>(rows_of(column));
    return !kept.is_optional || in_.has(name);
  }
  template <class Column>
  void operator()(const std::string& name, Column& column, const Kept& kept = {}) const {
    if (!kept.is_optional || in_.has(name)) get(name, column, kept);
  }

 private:
  template <class Matrix>
  requires requires { Matrix::ColsAtCompileTime; }
  void get(const std::string& name, Matrix& out, const Kept& kept) const {
    constexpr int kColumns = Matrix::ColsAtCompileTime;
    const Shape shape{rows_, kColumns == 1 ? std::size_t{0} : std::size_t{kColumns}};
    const auto fill = [&](const auto& values) {
      const auto rows = static_cast<Eigen::Index>(values.size() / kColumns);
      out = Eigen::Map<const Matrix>(values.data(), rows, kColumns);
    };
    if constexpr (std::is_same_v<typename Matrix::Scalar, double>)
      fill(in_.numbers(name, kept.unit, shape, kept.may_be_nan));
    else
      fill(in_.integers(name, kept.unit, shape));
  }
  void get(const std::string& name, std::vector<std::string>& out, const Kept&) const {
    out = in_.strings(name, rows_);
  }
  void get(const std::string& name, std::vector<std::int32_t>& out, const Kept& kept) const {
    out = in_.integers(name, kept.unit, {rows_, 0});
  }
  void get(const std::string& name, std::vector<char>& out, const Kept& kept) const {
    const auto values = in_.bytes(name, kept.unit, {rows_, 0});
    out.assign(values.begin(), values.end());
  }
  template <class Code>
  void get(const std::string& name, std::vector<Code>& out, const Kept& kept) const {
    out.clear();
    for (const int code : read_codes(in_, name, rows_, kept.names))
      out.push_back(static_cast<Code>(code));
  }

  const Reader& in_;
  std::size_t rows_ = kAny;
};

class ColumnWriter {
 public:
  explicit ColumnWriter(Writer& out) : out_(out) {}

  template <class Column>
  bool first(const std::string& name, const Column& column, const Kept& kept = {}) {
    (*this)(name, column, kept);
    return !kept.is_optional || rows_of(column) > 0;
  }
  template <class Column>
  void operator()(const std::string& name, const Column& column, const Kept& kept = {}) {
    if (kept.is_optional && rows_of(column) == 0) return;
    put(name, column, kept);
    if (!kept.names.empty())
      out_.attribute(name, "names", std::vector<std::string>(kept.names.begin(), kept.names.end()));
  }

 private:
  template <class Column>
  void put(const std::string& name, const Column& column, const Kept& kept) {
    const auto rows = static_cast<std::size_t>(rows_of(column));
    if constexpr (requires { Column::ColsAtCompileTime; }) {
      constexpr int kColumns = Column::ColsAtCompileTime;
      const Shape shape{rows, kColumns == 1 ? std::size_t{0} : std::size_t{kColumns}};
      if constexpr (std::is_same_v<typename Column::Scalar, double>)
        out_.numbers(name, kept.unit, column.data(), shape);
      else
        out_.integers(name, kept.unit, column.data(), shape);
    } else if constexpr (std::is_same_v<Column, std::vector<std::string>>) {
      out_.strings(name, column);
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
/// Throws what `complain` makes where a column has other rows than the first of its group.
class RowChecker {
 public:
  explicit RowChecker(const Complain& complain) : complain_(complain) {}

  template <class Column>
  bool first(const std::string&, const Column& column, const Kept& = {}) {
    rows_ = rows_of(column);
    return true;
  }
  template <class Column>
  void operator()(const std::string& name, const Column& column, const Kept& kept = {}) const {
    if (!kept.is_optional || rows_of(column) > 0)
      check_rows(complain_, name, rows_of(column), rows_);
  }

 private:
  const Complain& complain_;
  Eigen::Index rows_ = 0;
};

void check_finite(const Complain& complain, const std::string& name, const Points& points);
/// Every row has length 1 within 1e-6 (float32 sources pass).
void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors);
/// Every index in [0, end).
void check_indices(const Complain& complain, const std::string& name, const std::int32_t* indices,
                   Eigen::Index rows, Eigen::Index columns, Eigen::Index end);
void check_flags(const Complain& complain, const std::string& name, const std::vector<char>& flags);

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

/// The same of one part's numbers under `name`, of P = points rows.
void check_controls(const Complain& complain, const std::string& name, const runtime::Part& part,
                    const Controls& controls, const CurveBasis& basis, Eigen::Index points);

/// Columns of a Relaxation, R: Relaxation or const Relaxation; none where a body has none.
template <class R, class F>
void relaxation_columns(R& relaxation, F& f) {
  if (!f.first("relaxation/share", relaxation.share, {.is_optional = true})) return;
  f("relaxation/time", relaxation.time_s, {.unit = "s"});
}
void check_relaxation(const Complain& complain, const Relaxation& relaxation);

/// Columns of how a body softens: r, m over e and beta; reach. V: VectorXd or const VectorXd; none
/// where it does not.
template <class V, class F>
void damage_columns(V& softening, V& reach_m, F& f) {
  if (!f.first("damage/softening", softening, {.is_optional = true})) return;
  f.first("damage/reach", reach_m, {.unit = "m"});
}

/// Columns of how tools feel each other: l; a_k and b_k of (M62). V: VectorXd or const VectorXd;
/// none where they do not.
template <class V, class F>
void coupling_columns(V& length_m, V& isotropic_m_N, V& tangential_m_N, F& f) {
  if (!f.first("coupling/length", length_m, {.unit = "m", .is_optional = true})) return;
  f.first("coupling/give", isotropic_m_N, {.unit = "m/N"});
  f("coupling/across", tangential_m_N, {.unit = "m/N"});
}

}  // namespace palpate::h5
