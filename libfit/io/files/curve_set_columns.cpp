#include "libfit/io/files/curve_set_columns.hpp"

#include <cmath>
#include <limits>

namespace palpate::h5 {
namespace {

constexpr std::string_view kLeanGroup = "curves/lean";

std::string group_of(int kind) {
  return "curves/" + std::string(kCurveNames[static_cast<std::size_t>(kind)]);
}

void check_basis(const Complain& complain, const std::string& group, const CurveBasis& basis) {
  try {
    tabulate(basis);
  } catch (const Error& error) {
    throw complain(group + "/knots", error.fact());
  }
}

bool is_float32(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() &&
         static_cast<double>(static_cast<float>(value)) == value;
}

/// leading: columns that are zero. rises: along each row.
void check_values(const Complain& complain, const std::string& name, const Controls& controls,
                  Eigen::Index leading = 1, bool rises = true) {
  for (Eigen::Index i = 0; i < controls.rows(); ++i) {
    const std::string row = "row " + std::to_string(i);
    if (!controls.row(i).head(leading).isZero(0))
      throw complain(name, row + " does not start at 0");
    for (Eigen::Index j = 0; j < controls.cols(); ++j) {
      if (!std::isfinite(controls(i, j))) throw complain(name, row + " is not a finite number");
      if (!is_float32(controls(i, j))) throw complain(name, row + " is not exact in float32");
      if (rises && j > 0 && controls(i, j) < controls(i, j - 1))
        throw complain(name, row + " falls");
    }
  }
}

CurveFamily read_family(const Reader& reader) {
  const std::string family = reader.text_attribute("", "family");
  for (const CurveFamilyName& row : kCurveFamilyNames)
    if (row.name == family) return row.family;
  throw reader.error("", "curve family `" + family + "` is unknown to this version");
}

CurveBasis read_basis(const Reader& reader, const std::string& group) {
  CurveBasis basis;
  basis.knots_m = reader.numbers(group + "/knots", "m", {kAny, 0});
  const std::int64_t degree = reader.integer_attribute(group, "degree");
  if (degree < 1 || degree > 4) throw reader.error(group, "degree is not 1 to 4");
  basis.degree = static_cast<int>(degree);
  check_basis(complain_about(reader), group, basis);
  return basis;
}

Controls read_controls(const Reader& reader, const std::string& group, const char* unit,
                       std::size_t points, int columns) {
  const auto size = static_cast<std::size_t>(columns);
  const auto values = reader.numbers(group + "/controls", unit, {points, size});
  return Eigen::Map<const Controls>(values.data(), static_cast<Eigen::Index>(points), columns);
}

void write_curves_of(Writer& writer, const std::string& group, const char* unit,
                     const CurveBasis& basis, const Controls& controls) {
  const auto& knots = basis.knots_m;
  writer.numbers(group + "/knots", "m", knots.data(), {knots.size(), 0});
  writer.numbers(
      group + "/controls", unit, controls.data(),
      {static_cast<std::size_t>(controls.rows()), static_cast<std::size_t>(controls.cols())});
  writer.attribute(group, "degree", basis.degree);
}

void check_columns(const Complain& complain, const std::string& name, const Controls& controls,
                   int columns) {
  if (controls.cols() != columns)
    throw complain(name, "has " + std::to_string(controls.cols()) +
                             " columns where the basis has " + std::to_string(columns));
}

}  // namespace

CurveSet read_curve_set(const Reader& reader, std::size_t points) {
  const CurveFamily family = read_family(reader);
  CurveSet curves;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    curves.basis[k] = read_basis(reader, group_of(kind));
    curves.control[k] = read_controls(reader, group_of(kind), "N", points, curves.basis[k].size());
  }
  if (!leans(family)) return curves;
  const std::string group(kLeanGroup);
  curves.lean_basis = read_basis(reader, group);
  curves.lean = read_controls(reader, group, "m", points, 3 * curves.lean_basis.size());
  return curves;
}

void write_curve_set(Writer& writer, const CurveSet& curves) {
  const auto family = static_cast<std::size_t>(curves.family());
  writer.attribute("", "family", kCurveFamilyNames[family].name);
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    write_curves_of(writer, group_of(kind), "N", curves.basis[k], curves.control[k]);
  }
  if (leans(curves.family()))
    write_curves_of(writer, std::string(kLeanGroup), "m", curves.lean_basis, curves.lean);
}

void check_controls(const Complain& complain, const std::string& name, const Controls& controls,
                    const CurveBasis& basis, Eigen::Index points) {
  check_rows(complain, name, controls.rows(), points);
  check_columns(complain, name, controls, basis.size());
  check_values(complain, name, controls);
}

void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points) {
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const std::string name = group_of(kind) + "/controls";
    check_basis(complain, group_of(kind), curves.basis[k]);
    check_controls(complain, name, curves.control[k], curves.basis[k], points);
  }
  if (!leans(curves.family())) return;
  const std::string group(kLeanGroup), name = group + "/controls";
  check_basis(complain, group, curves.lean_basis);
  check_rows(complain, name, curves.lean.rows(), points);
  check_columns(complain, name, curves.lean, 3 * curves.lean_basis.size());
  check_values(complain, name, curves.lean, 3, false);
}

}  // namespace palpate::h5
