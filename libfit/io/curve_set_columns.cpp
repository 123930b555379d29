#include "libfit/io/curve_set_columns.hpp"

#include <cmath>
#include <limits>

namespace palpate::h5 {
namespace {

constexpr std::string_view kFamily = "separable";

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

void check_controls(const Complain& complain, const std::string& name, const Controls& controls) {
  for (Eigen::Index i = 0; i < controls.rows(); ++i) {
    const std::string row = "row " + std::to_string(i);
    if (controls(i, 0) != 0) throw complain(name, row + " does not start at 0");
    for (Eigen::Index j = 0; j < controls.cols(); ++j) {
      if (!std::isfinite(controls(i, j))) throw complain(name, row + " is not a finite number");
      if (!is_float32(controls(i, j))) throw complain(name, row + " is not exact in float32");
      if (j > 0 && controls(i, j) < controls(i, j - 1)) throw complain(name, row + " falls");
    }
  }
}

}  // namespace

CurveSet read_curve_set(const Reader& reader, std::size_t points) {
  const std::string family = reader.text_attribute("", "family");
  if (family != kFamily)
    throw reader.error("", "curve family `" + family + "` is unknown to this version");
  CurveSet curves;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const std::string group = group_of(kind);
    curves.basis[k].knots_m = reader.numbers(group + "/knots", "m", {kAny, 0});
    const std::int64_t degree = reader.integer_attribute(group, "degree");
    if (degree < 1 || degree > 4) throw reader.error(group, "degree is not 1 to 4");
    curves.basis[k].degree = static_cast<int>(degree);
    check_basis(complain_about(reader), group, curves.basis[k]);
    const auto size = static_cast<std::size_t>(curves.basis[k].size());
    const auto values = reader.numbers(group + "/controls", "N", {points, size});
    curves.control[k] = Eigen::Map<const Controls>(
        values.data(), static_cast<Eigen::Index>(points), static_cast<Eigen::Index>(size));
  }
  return curves;
}

void write_curve_set(Writer& writer, const CurveSet& curves) {
  writer.attribute("", "family", kFamily);
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const auto& knots = curves.basis[k].knots_m;
    const Controls& controls = curves.control[k];
    writer.numbers(group_of(kind) + "/knots", "m", knots.data(), {knots.size(), 0});
    writer.numbers(
        group_of(kind) + "/controls", "N", controls.data(),
        {static_cast<std::size_t>(controls.rows()), static_cast<std::size_t>(controls.cols())});
    writer.attribute(group_of(kind), "degree", curves.basis[k].degree);
  }
}

void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points) {
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const std::string name = group_of(kind) + "/controls";
    check_basis(complain, group_of(kind), curves.basis[k]);
    check_rows(complain, name, curves.control[k].rows(), points);
    if (curves.control[k].cols() != curves.basis[k].size())
      throw complain(name, "has " + std::to_string(curves.control[k].cols()) +
                               " columns where the basis has " +
                               std::to_string(curves.basis[k].size()));
    check_controls(complain, name, curves.control[k]);
  }
}

}  // namespace palpate::h5
