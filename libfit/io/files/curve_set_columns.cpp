#include "libfit/io/files/columns.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/geometry.hpp"

namespace palpate::h5 {
namespace {

std::string group_of(const runtime::Part& part) { return std::string("curves/") + part.name; }

void check_basis(const Complain& complain, const std::string& group, const CurveBasis& basis) {
  try {
    tabulate(basis);
  } catch (const Error& error) {
    throw complain(group + "/knots", error.fact());
  }
}

void check_values(const Complain& complain, const std::string& name, const runtime::Part& part,
                  const Controls& controls, Eigen::Index columns, Eigen::Index points) {
  check_rows(complain, name, controls.rows(), points);
  if (controls.cols() != columns)
    throw complain(name, "has " + std::to_string(controls.cols()) +
                             " columns where the basis has " + std::to_string(columns));
  for (Eigen::Index i = 0; i < controls.rows(); ++i) {
    const std::string row = "row " + std::to_string(i);
    if (part.starts_at_zero && !controls.row(i).head(part.width).isZero(0))
      throw complain(name, row + " does not start at 0");
    for (Eigen::Index j = 0; j < controls.cols(); ++j) {
      const double value = controls(i, j);
      if (!std::isfinite(value)) throw complain(name, row + " is not a finite number");
      if (rounded_to_float(value) != value) throw complain(name, row + " is not exact in float32");
      if (part.rises && j >= part.width && value < controls(i, j - part.width))
        throw complain(name, row + " falls");
      if (value < part.min || value > part.max) throw complain(name, row + " is out of bounds");
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
  basis.degree = static_cast<int>(reader.integer_attribute(group, "degree"));
  check_basis(complain_about(reader), group, basis);
  return basis;
}

}  // namespace

CurveSet read_curve_set(const Reader& reader, std::size_t points) {
  CurveSet curves(read_family(reader));
  const auto parts = parts_of(curves.family);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].is_curve()) curves.basis[i] = read_basis(reader, group_of(parts[i]));
    const int columns = parts[i].width * size_of(parts[i], curves.basis[i]);
    const auto values = reader.numbers(group_of(parts[i]) + "/controls", parts[i].unit,
                                       {points, static_cast<std::size_t>(columns)});
    curves.control[i] =
        Eigen::Map<const Controls>(values.data(), static_cast<Eigen::Index>(points), columns);
  }
  curves.first_row_m = reader.numbers("curves/first_row", "m", {1, 0}).front();
  ColumnReader in(reader);
  relaxation_columns(curves.relaxation, in);
  if (reader.has("damage/softening")) {
    const auto n = reader.numbers("damage/softening", kNoUnit, {3, 0});  // r, m over e and beta
    curves.damage = {n[0], n[1], n[2], reader.numbers("damage/reach", "m", {1, 0}).front()};
  }
  if (reader.has("coupling/length")) {  // l; a_k and b_k of (M62)
    constexpr Shape kScales{runtime::kCouplingScales, 0};
    runtime::CouplingView& coupling = curves.coupling;
    coupling.length_m = reader.numbers("coupling/length", "m", {1, 0}).front();
    std::ranges::copy(reader.numbers("coupling/give", "m/N", kScales), coupling.isotropic_m_N);
    std::ranges::copy(reader.numbers("coupling/across", "m/N", kScales), coupling.tangential_m_N);
  }
  return curves;
}

void write_curve_set(Writer& writer, const CurveSet& curves) {
  writer.attribute("", "family", name_of(curves.family));
  const auto parts = parts_of(curves.family);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string group = group_of(parts[i]);
    const auto& knots = curves.basis[i].knots_m;
    if (parts[i].is_curve()) writer.numbers(group + "/knots", "m", knots.data(), {knots.size(), 0});
    writer.numbers(group + "/controls", parts[i].unit, curves.control[i].data(),
                   {static_cast<std::size_t>(curves.control[i].rows()),
                    static_cast<std::size_t>(curves.control[i].cols())});
    if (parts[i].is_curve()) writer.attribute(group, "degree", curves.basis[i].degree);
  }
  writer.numbers("curves/first_row", "m", &curves.first_row_m, {1, 0});
  ColumnWriter out(writer);
  relaxation_columns(curves.relaxation, out);
  if (const runtime::DamageView& damage = curves.damage; damage.softens()) {
    const double softening[] = {damage.r, damage.scale, damage.beta};
    writer.numbers("damage/softening", kNoUnit, softening, {3, 0});
    writer.numbers("damage/reach", "m", &damage.reach_m, {1, 0});
  }
  const runtime::CouplingView& coupling = curves.coupling;
  if (!coupling.is_any()) return;
  writer.numbers("coupling/length", "m", &coupling.length_m, {1, 0});
  writer.numbers("coupling/give", "m/N", coupling.isotropic_m_N, {runtime::kCouplingScales, 0});
  writer.numbers("coupling/across", "m/N", coupling.tangential_m_N, {runtime::kCouplingScales, 0});
}

void check_relaxation(const Complain& complain, const Relaxation& relaxation) {
  check_rows(complain, "relaxation/time", relaxation.time_s.size(), relaxation.branches());
  if (relaxation.branches() > runtime::kMaxBranches)
    throw complain("relaxation/share",
                   "has more than " + std::to_string(runtime::kMaxBranches) + " rows");
  for (Eigen::Index k = 0; k < relaxation.branches(); ++k) {
    const std::string row = "row " + std::to_string(k);
    if (!(relaxation.share[k] > 0 && relaxation.share[k] <= runtime::kMaxShare))
      throw complain("relaxation/share", row + " is not above 0 and up to 1000");
    if (!(relaxation.time_s[k] >= runtime::kMinRelaxation_s &&
          relaxation.time_s[k] <= runtime::kMaxRelaxation_s) ||
        (k > 0 && !(relaxation.time_s[k] > relaxation.time_s[k - 1])))
      throw complain("relaxation/time", row + " is not above the one before, 1e-4 s to 1e6 s");
  }
}

void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points) {
  check_relaxation(complain, curves.relaxation);
  const runtime::DamageView& damage = curves.damage;
  if (damage.softens() &&
      !(damage.r >= runtime::kMinDamage && damage.r <= runtime::kMaxDamage && damage.scale >= 0 &&
        damage.scale <= runtime::kMaxDamage && damage.beta >= 0 &&
        damage.beta <= runtime::kMaxDamage && damage.scale + damage.beta > 0))
    throw complain("damage/softening", "is out of range");
  if (!(damage.reach_m >= 0 && damage.reach_m <= runtime::kMaxLength_m))
    throw complain("damage/reach", "is out of range");
  if (!(curves.first_row_m >= 0 && std::isfinite(curves.first_row_m)))
    throw complain("curves/first_row", "is no depth");
  if (curves.coupling.is_any() && !runtime::is_possible(curves.coupling))
    throw complain("coupling/give", "is out of range");
  const auto parts = parts_of(curves.family);
  if (curves.basis.size() != parts.size() || curves.control.size() != parts.size())
    throw complain("curves", "has not the parts of its family");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].is_curve()) check_basis(complain, group_of(parts[i]), curves.basis[i]);
    check_values(complain, group_of(parts[i]) + "/controls", parts[i], curves.control[i],
                 parts[i].width * size_of(parts[i], curves.basis[i]), points);
  }
}

}  // namespace palpate::h5
