#include "libfit/assets/exporters.hpp"

#include "libfit/core/error.hpp"

namespace palpate {

ExportReport written(const Model& model, std::uint64_t bytes) {
  ExportReport report;
  report.bytes = bytes;
  report.vertices = static_cast<int>(model.surface.vertices.rows());
  report.triangles = static_cast<int>(model.surface.triangles.rows());
  return report;
}

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
