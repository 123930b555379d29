#include "libfit/io/files/probe_group.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::h5 {
namespace {

constexpr std::string_view kGroup = "probe/";
constexpr std::array<std::string_view, 6> kOwnNames{"shape",   "friction",      "orientation",
                                                    "heading", "mesh/vertices", "mesh/triangles"};

std::string_view unit_of(std::string_view key) {
  return probe_dimension(key) == Dimension::angle ? "rad" : "m";
}

std::optional<Vec3> read_direction(const Reader& reader, const std::string& name) {
  if (!reader.has(name)) return std::nullopt;
  const auto values = reader.numbers(name, kNoUnit, {3, 0});
  return Vec3(values[0], values[1], values[2]);
}

void check(const ProbeSpec& probe, const Complain& complain) {
  if (!(std::isfinite(probe.friction) && probe.friction >= 0))
    throw complain("probe/friction", "is negative or not finite");
  for (const auto& [key, values] : probe.values) {
    const std::string name = "probe/" + key;
    if (key.find('/') != std::string::npos ||
        std::find(kOwnNames.begin(), kOwnNames.end(), key) != kOwnNames.end())
      throw complain(name, "is no name of a shape's number");
    if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
      throw complain(name, "is not finite");
  }
  for (const auto& [name, direction] : {std::pair{"probe/orientation", probe.orientation},
                                        std::pair{"probe/heading", probe.heading}})
    if (direction && !direction->allFinite()) throw complain(name, "is not finite");
  check_finite(complain, "probe/mesh/vertices", probe.mesh.vertices);
  check_indices(complain, "probe/mesh/triangles", probe.mesh.triangles.data(),
                probe.mesh.triangles.rows(), 3, probe.mesh.vertices.rows());
}

}  // namespace

std::optional<ProbeSpec> read_probe(const Reader& reader) {
  if (!reader.has("probe/shape")) return std::nullopt;
  ProbeSpec probe;
  probe.shape = reader.strings("probe/shape", 1).front();
  probe.friction = reader.numbers("probe/friction", kNoUnit, {1, 0}).front();
  for (const std::string& name : reader.data_sets()) {
    if (!name.starts_with(kGroup)) continue;
    const std::string key = name.substr(kGroup.size());
    if (std::find(kOwnNames.begin(), kOwnNames.end(), key) == kOwnNames.end())
      probe.values[key] = reader.numbers(name, unit_of(key), {kAny, 0});
  }
  probe.orientation = read_direction(reader, "probe/orientation");
  probe.heading = read_direction(reader, "probe/heading");
  if (reader.has("probe/mesh/vertices")) {
    probe.mesh.vertices = read_points(reader, "probe/mesh/vertices", "m", kAny);
    probe.mesh.triangles = read_triangles(reader, "probe/mesh/triangles", kAny);
  }
  check(probe, complain_about(reader));
  return probe;
}

void write_probe(Writer& writer, const std::optional<ProbeSpec>& probe, const Complain& complain) {
  if (!probe) return;
  check(*probe, complain);
  writer.strings("probe/shape", {probe->shape});
  writer.numbers("probe/friction", kNoUnit, &probe->friction, {1, 0});
  for (const auto& [key, values] : probe->values)
    writer.numbers("probe/" + key, unit_of(key), values.data(), {values.size(), 0});
  for (const auto& [name, direction] : {std::pair{"probe/orientation", probe->orientation},
                                        std::pair{"probe/heading", probe->heading}})
    if (direction) writer.numbers(name, kNoUnit, direction->data(), {3, 0});
  if (probe->mesh.vertices.rows() == 0) return;
  write_points(writer, "probe/mesh/vertices", "m", probe->mesh.vertices);
  write_triangles(writer, "probe/mesh/triangles", probe->mesh.triangles);
}

}  // namespace palpate::h5
