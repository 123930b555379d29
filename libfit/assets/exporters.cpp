#include "libfit/assets/exporters.hpp"

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr Exporter kExporters[] = {
    {"palp", ".palp", "runtime asset for the haptic engine", export_palp},
    {"vtu", ".vtu", "surface with forces, stiffness and friction for ParaView", export_vtu},
};

}  // namespace

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

}  // namespace palpate
