#include "libfit/io/files/columns.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

h5::Reader open_any(const std::filesystem::path& path) {
  return h5::Reader(path, "Name a file that `palpate` made.");
}

std::string known_schema(const h5::Reader& reader) {
  const std::string found = reader.text_if_any("", "schema");
  if (found != kSignalsSchema.name &&
      std::ranges::find(kFileSchemas, found, &FileSchema::name) == kFileSchemas.end())
    throw reader.error("", found.empty() ? "is an HDF5 file, but not one of Palpate's"
                                         : "holds `" + found + "`, which is unknown here");
  return found;
}

}  // namespace

std::string schema_of(const std::filesystem::path& path) { return known_schema(open_any(path)); }

Attributes read_attributes(const std::filesystem::path& path) {
  const h5::Reader reader = open_any(path);
  known_schema(reader);
  Attributes attributes = reader.root_texts();
  for (const auto* own : {"schema", "family"}) attributes.erase(own);
  return attributes;
}

FileDescription describe(const std::filesystem::path& path) {
  const h5::Reader reader = open_any(path);
  FileDescription description;
  description.schema = known_schema(reader);
  description.version = static_cast<int>(reader.integer_attribute("", "version"));
  description.attributes = reader.root_texts();
  description.attributes.erase("schema");
  for (const auto& name : reader.data_sets())
    description.data_sets.push_back(
        {name, reader.type_of(name), reader.shape_of(name), reader.text_if_any(name, "unit")});
  return description;
}

}  // namespace palpate

namespace palpate::h5 {

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
  reader.expect(schema.name);
  return reader;
}

Writer create(const std::filesystem::path& path, const FileSchema& schema,
              const Attributes& attributes) {
  for (const std::string reserved : {"schema", "version", "family"})
    if (attributes.count(reserved) != 0)
      throw Error(path.string(), "attribute `" + reserved + "` is the file's own",
                  "Name it otherwise.");
  return Writer(path, schema.name, attributes);
}

std::vector<int> read_codes(const Reader& reader, const std::string& column, std::size_t rows,
                            std::span<const std::string_view> names) {
  std::vector<std::string> listed(names.begin(), names.end());
  if (reader.has_attribute(column, "names")) listed = reader.texts_attribute(column, "names");
  std::vector<int> meanings, out;
  for (const auto& name : listed) {
    const auto known = std::ranges::find(names, name);
    if (known == names.end()) throw reader.error(column, "names an unknown code `" + name + "`");
    meanings.push_back(static_cast<int>(known - names.begin()));
  }
  for (const std::int8_t code : reader.integers<std::int8_t>(column, kNoUnit, {rows, 0})) {
    if (code < 0 || static_cast<std::size_t>(code) >= meanings.size())
      throw reader.error(column,
                         fmt::format("row {} has code {} without a name", out.size(), code));
    out.push_back(meanings[code]);
  }
  return out;
}

void check_rows(const Complain& complain, const std::string& name, Eigen::Index found,
                Eigen::Index expected) {
  if (found != expected) throw complain(name, fmt::format("has {} rows, not {}", found, expected));
}

void check_finite(const Complain& complain, const std::string& name, const double* values,
                  Eigen::Index count, Eigen::Index width, bool may_be_nan) {
  for (Eigen::Index i = 0; i < count; ++i)
    if (!std::isfinite(values[i]) && !(may_be_nan && std::isnan(values[i])))
      throw complain(name, fmt::format("row {} is not a finite number", i / width));
}

void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors,
                       bool may_be_zero) {
  for (Eigen::Index i = 0; i < vectors.rows(); ++i)
    if (const double length = vectors.row(i).norm();
        !(std::abs(length - 1) < 1e-6 || (may_be_zero && length == 0)))
      throw complain(name, fmt::format("row {} is not a unit vector", i));
}

void check_flags(const Complain& complain, const std::string& name,
                 const std::vector<char>& flags) {
  const auto bad =
      std::find_if(flags.begin(), flags.end(), [](char f) { return f != 0 && f != 1; });
  if (bad != flags.end())
    throw complain(name, fmt::format("row {} is neither 0 nor 1", bad - flags.begin()));
}

namespace {

constexpr std::array<std::string_view, 5> kOwnNames{"shape", "friction", "orientation",
                                                    "mesh/vertices", "mesh/triangles"};

std::string_view unit_of(std::string_view key) {
  return probe_dimension(key) == Dimension::angle ? "rad" : "m";
}

void check(const ProbeSpec& probe, const Complain& complain, const std::string& group) {
  if (!(std::isfinite(probe.friction) && probe.friction >= 0))
    throw complain(group + "friction", "is negative or not finite");
  for (const auto& [key, values] : probe.values) {
    const std::string name = group + key;
    if (key.find('/') != std::string::npos ||
        std::find(kOwnNames.begin(), kOwnNames.end(), key) != kOwnNames.end())
      throw complain(name, "is no name of a shape's number");
    if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
      throw complain(name, "is not finite");
  }
  if (probe.orientation && !probe.orientation->allFinite())
    throw complain(group + "orientation", "is not finite");
  ColumnChecker(complain).first(group + "mesh/vertices", probe.mesh.vertices);
  check_indices(complain, group + "mesh/triangles", probe.mesh.triangles,
                probe.mesh.vertices.rows());
}

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

std::optional<ProbeSpec> read_probe(const Reader& reader, const std::string& group) {
  if (!reader.has(group + "shape")) return std::nullopt;
  ProbeSpec probe;
  probe.shape = reader.strings(group + "shape", 1).front();
  probe.friction = reader.numbers(group + "friction", kNoUnit, {1, 0}).front();
  for (const std::string& name : reader.data_sets()) {
    if (!name.starts_with(group)) continue;
    const std::string key = name.substr(group.size());
    if (std::find(kOwnNames.begin(), kOwnNames.end(), key) == kOwnNames.end())
      probe.values[key] = reader.numbers(name, unit_of(key), {kAny, 0});
  }
  if (reader.has(group + "orientation"))
    probe.orientation = Vec3(reader.numbers(group + "orientation", kNoUnit, {3, 0}).data());
  if (reader.has(group + "mesh/vertices")) {
    ColumnReader in(reader);
    in.first(group + "mesh/vertices", probe.mesh.vertices, {"m"});
    in.first(group + "mesh/triangles", probe.mesh.triangles);
  }
  check(probe, complain_about(reader), group);
  return probe;
}

void write_probe(Writer& writer, const std::optional<ProbeSpec>& probe, const Complain& complain,
                 const std::string& group) {
  if (!probe) return;
  check(*probe, complain, group);
  writer.strings(group + "shape", {probe->shape});
  writer.numbers(group + "friction", kNoUnit, &probe->friction, {1, 0});
  for (const auto& [key, values] : probe->values)
    writer.numbers(group + key, unit_of(key), values.data(), {values.size(), 0});
  if (probe->orientation)
    writer.numbers(group + "orientation", kNoUnit, probe->orientation->data(), {3, 0});
  if (probe->mesh.vertices.rows() == 0) return;
  ColumnWriter out(writer);
  out(group + "mesh/vertices", probe->mesh.vertices, {"m"});
  out(group + "mesh/triangles", probe->mesh.triangles);
}

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
  if (reader.has("relaxation/radius"))
    curves.relaxation.radius_m = reader.numbers("relaxation/radius", "m", {1, 0}).front();
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
  if (curves.relaxation.radius_m > 0)
    writer.numbers("relaxation/radius", "m", &curves.relaxation.radius_m, {1, 0});
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
