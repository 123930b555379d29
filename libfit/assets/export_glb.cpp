#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "libfit/assets/exporters.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;
using Floats = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

// glTF's colours are linear: sRGB's curve (IEC 61966-2-1) is undone.
float linear(std::uint8_t part) {
  const double c = part / 255.0;
  return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

Floats normals_of(const Surface& surface) {
  Points normals = vertex_normals(surface);
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    if (!(normals.row(v).squaredNorm() > 0.5)) normals.row(v) << 0, 0, 1;
  return normals.cast<float>();
}

/// A binary glTF in the making (Khronos, glTF 2.0, 4.4): JSON and one buffer.
struct Glb {
  enum Code : int { kFloat = 5126, kUnsigned = 5125, kVertices = 34962, kIndices = 34963 };
  Json json{{"asset", {{"version", "2.0"}, {"generator", "palpate"}}}};
  std::string buffer;

  /// Number of a new accessor of these bytes; every element has four-byte parts.
  int add(const void* bytes, std::size_t size, Json accessor, int target) {
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", size}, {"target", target}});
    buffer.append(static_cast<const char*>(bytes), size);
    accessor["bufferView"] = json["bufferViews"].size() - 1;
    json["accessors"].push_back(std::move(accessor));
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int add(const Floats& rows) {
    Json low, high;
    for (int k = 0; k < 3; ++k) {
      low.push_back(rows.col(k).minCoeff());
      high.push_back(rows.col(k).maxCoeff());
    }
    return add(rows.data(), rows.size() * sizeof(float),
               {{"componentType", kFloat},
                {"count", rows.rows()},
                {"type", "VEC3"},
                {"min", low},
                {"max", high}},
               kVertices);
  }
  std::string bytes() {
    json["buffers"] = {{{"byteLength", buffer.size()}}};
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string out;
    const auto word = [&](std::size_t value) {
      const auto four = static_cast<std::uint32_t>(value);
      out.append(reinterpret_cast<const char*>(&four), sizeof four);
    };
    for (const std::size_t value :
         {std::size_t{0x46546C67}, std::size_t{2}, 28 + text.size() + buffer.size(), text.size(),
          std::size_t{0x4E4F534A}})
      word(value);
    out += text;
    word(buffer.size());
    word(0x004E4942);
    return out + buffer;
  }
};

}  // namespace

ExportReport export_glb(const Model& model, const std::filesystem::path& path,
                        const ExportOptions& options) {
  const StiffnessMap map = stiffness_map(model, options.map_depth_m);
  const Surface& surface = model.surface;
  const Floats rest = surface.vertices.cast<float>(), normals = normals_of(surface);
  Floats colour(rest.rows(), 3);
  for (Eigen::Index v = 0; v < rest.rows(); ++v)
    for (int k = 0; k < 3; ++k) colour(v, k) = linear(map.colour[v][k]);
  Glb glb;
  Json primitive{{"material", 0}};
  primitive["attributes"] = {
      {"POSITION", glb.add(rest)}, {"NORMAL", glb.add(normals)}, {"COLOR_0", glb.add(colour)}};
  const std::size_t corners = surface.triangles.size();
  primitive["indices"] = glb.add(
      surface.triangles.data(), corners * sizeof(std::int32_t),
      {{"componentType", Glb::kUnsigned}, {"count", corners}, {"type", "SCALAR"}}, Glb::kIndices);
  const Json extras{{"depth_m", map.depth_m}, {"low_N_m", map.low_N_m}, {"high_N_m", map.high_N_m}};
  glb.json["scene"] = 0;
  glb.json["scenes"] = {{{"nodes", {0}}}};
  glb.json["nodes"] = {{{"mesh", 0}}};
  glb.json["meshes"] = {
      {{"name", "normal stiffness"}, {"extras", extras}, {"primitives", {primitive}}}};
  glb.json["materials"] = {
      {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.6}}}}};
  const std::string bytes = glb.bytes();
  write_file_atomically(path, bytes);
  return written(model, bytes.size());
}

}  // namespace palpate
