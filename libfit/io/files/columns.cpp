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

void check_unit_length(const Complain& complain, const std::string& name, const Points& vectors) {
  for (Eigen::Index i = 0; i < vectors.rows(); ++i)
    if (!(std::abs(vectors.row(i).norm() - 1) < 1e-6))
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

}  // namespace palpate::h5
