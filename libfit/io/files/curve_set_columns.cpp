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
                  const Controls& controls) {
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
  const std::int64_t degree = reader.integer_attribute(group, "degree");
  if (degree < 1 || degree > 4) throw reader.error(group, "degree is not 1 to 4");
  basis.degree = static_cast<int>(degree);
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
  Eigen::VectorXd softening, reach_m;
  damage_columns(softening, reach_m, in);
  if (softening.size() == 3 && reach_m.size() == 1)
    curves.damage = {softening[0], softening[1], softening[2], reach_m[0]};
  else if (softening.size() > 0)
    throw reader.error("damage", "has not r, m, beta and a reach");
  Eigen::VectorXd length_m, isotropic_m_N, tangential_m_N;
  coupling_columns(length_m, isotropic_m_N, tangential_m_N, in);
  if (length_m.size() == 1 && isotropic_m_N.size() == runtime::kCouplingScales &&
      tangential_m_N.size() == runtime::kCouplingScales) {
    curves.coupling.length_m = length_m[0];
    std::ranges::copy(isotropic_m_N, curves.coupling.isotropic_m_N);
    std::ranges::copy(tangential_m_N, curves.coupling.tangential_m_N);
  } else if (length_m.size() > 0) {
    throw reader.error("coupling", "has not a length and the compliances of its scales");
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
  if (curves.damage.softens()) {
    const Eigen::VectorXd softening =
        Eigen::Vector3d(curves.damage.r, curves.damage.scale, curves.damage.beta);
    const Eigen::VectorXd reach_m = Eigen::VectorXd::Constant(1, curves.damage.reach_m);
    damage_columns(softening, reach_m, out);
  }
  if (!curves.coupling.is_any()) return;
  using Scales = Eigen::Map<const Eigen::Vector<double, runtime::kCouplingScales>>;
  const Eigen::VectorXd length_m = Eigen::VectorXd::Constant(1, curves.coupling.length_m),
                        isotropic_m_N = Scales(curves.coupling.isotropic_m_N),
                        tangential_m_N = Scales(curves.coupling.tangential_m_N);
  coupling_columns(length_m, isotropic_m_N, tangential_m_N, out);
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

namespace {

void check_damage(const Complain& complain, const runtime::DamageView& damage) {
  if (!damage.softens()) return;
  if (!(damage.r >= runtime::kMinDamage && damage.r <= runtime::kMaxDamage && damage.scale >= 0 &&
        damage.scale <= runtime::kMaxDamage && damage.beta >= 0 &&
        damage.beta <= runtime::kMaxDamage && damage.scale + damage.beta > 0))
    throw complain("damage/softening", "is out of range");
  if (!(damage.reach_m >= 0 && damage.reach_m <= runtime::kMaxLength_m))
    throw complain("damage/reach", "is out of range");
}

}  // namespace

void check_controls(const Complain& complain, const std::string& name, const runtime::Part& part,
                    const Controls& controls, const CurveBasis& basis, Eigen::Index points) {
  const int columns = part.width * size_of(part, basis);
  check_rows(complain, name, controls.rows(), points);
  if (controls.cols() != columns)
    throw complain(name, "has " + std::to_string(controls.cols()) +
                             " columns where the basis has " + std::to_string(columns));
  check_values(complain, name, part, controls);
}

void check_curve_set(const Complain& complain, const CurveSet& curves, Eigen::Index points) {
  check_relaxation(complain, curves.relaxation);
  check_damage(complain, curves.damage);
  if (!(curves.first_row_m >= 0 && std::isfinite(curves.first_row_m)))
    throw complain("curves/first_row", "is no depth");
  if (curves.coupling.is_any() && !runtime::is_possible(curves.coupling))
    throw complain("coupling/give", "is out of range");
  const auto parts = parts_of(curves.family);
  if (curves.basis.size() != parts.size() || curves.control.size() != parts.size())
    throw complain("curves", "has not the parts of its family");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].is_curve()) check_basis(complain, group_of(parts[i]), curves.basis[i]);
    check_controls(complain, group_of(parts[i]) + "/controls", parts[i], curves.control[i],
                   curves.basis[i], points);
  }
}

}  // namespace palpate::h5
