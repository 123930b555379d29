#include "libfit/assets/exporters.hpp"

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr Exporter kExporters[] = {
    {"palp", ".palp", "runtime asset for the haptic engine", export_palp},
    {"vtu", ".vtu", "surface with forces, stiffness and friction for ParaView", export_vtu},
    {"glb", ".glb", "surface coloured by stiffness with dents as morph targets (glTF 2.0)",
     export_glb},
    {"ply", ".ply", "surface coloured by stiffness", export_ply},
};

}  // namespace

ExportReport written(const Model& model, std::uint64_t bytes) {
  ExportReport report;
  report.bytes = bytes;
  report.vertices = static_cast<int>(model.surface.vertices.rows());
  report.triangles = static_cast<int>(model.surface.triangles.rows());
  return report;
}

std::span<const Exporter> exporters() { return kExporters; }

const Exporter& find_exporter(std::string_view name) {
  std::string names;
  for (const Exporter& exporter : kExporters) {
    if (exporter.name == name) return exporter;
    names += (names.empty() ? "" : ", ") + std::string(exporter.name);
  }
  throw Error("--format", "there is no asset format \"" + std::string(name) + "\"",
              "Choose one of: " + names + ".");
}

const Exporter& exporter_of_file(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  std::string known;
  for (const Exporter& exporter : kExporters) {
    if (exporter.extension == extension) return exporter;
    known += (known.empty() ? "" : ", ") + std::string(exporter.extension);
  }
  throw Error(path.string(),
              extension.empty() ? "its name does not say a format"
                                : "nothing is exported as \"" + extension + "\"",
              "The name says the format: let it end in one of " + known + ".");
}

}  // namespace palpate
