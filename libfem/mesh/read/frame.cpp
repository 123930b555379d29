#include "libfem/mesh/read/frame.hpp"

#include <string_view>

#include "libfem/mesh/read/vtk_xml_file.hpp"

namespace palpate {

std::string stated_frame(const std::filesystem::path& mesh_file) {
  using namespace mesh_read;
  const std::string extension = mesh_file.extension().string(), bytes = load_file(mesh_file);
  if (same_word(extension, ".vtp") || same_word(extension, ".vtu")) {
    Cursor file(bytes, mesh_file.string());
    return VtkXmlFile(file, same_word(extension, ".vtp") ? "PolyData" : "UnstructuredGrid")
        .field_text("SPACE");
  }
  // The longest header of 3D Slicer, that of PLY, is below 300 bytes.
  constexpr std::size_t kHeaderBytes = 1024;
  constexpr std::string_view kKey = "SPACE=";
  const std::string_view header = std::string_view(bytes).substr(0, kHeaderBytes);
  const std::size_t at = header.find(kKey);
  if (at == std::string_view::npos) return {};
  const std::string_view value = header.substr(at + kKey.size());
  return std::string(value.substr(0, value.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ")));
}

}  // namespace palpate
