#include "libfit/io/files/columns.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::h5 {
namespace {

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
  for (const std::int8_t code : reader.bytes(column, kNoUnit, {rows, 0})) {
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
  check_finite(complain, group + "mesh/vertices", probe.mesh.vertices);
  check_indices(complain, group + "mesh/triangles", probe.mesh.triangles.data(),
                probe.mesh.triangles.rows(), 3, probe.mesh.vertices.rows());
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
