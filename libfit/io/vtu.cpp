#include "libfit/io/vtu.hpp"

namespace palpate {

std::string VtuWriter::text(const Surface& surface, const std::string& scalars) {
  close("PointData", scalars.empty() ? "" : " Scalars=\"" + scalars + "\"");
  const auto* places = surface.vertices.data();
  add("Points", 3, std::vector<double>(places, places + surface.vertices.size()));
  close("Points");
  const auto* corners = surface.triangles.data();
  const auto cells = surface.triangles.rows();
  std::vector<std::int64_t> offsets;
  for (std::int64_t t = 1; t <= cells; ++t) offsets.push_back(3 * t);
  append("Int32", "connectivity", 1,
         std::vector<std::int32_t>(corners, corners + surface.triangles.size()));
  append("Int64", "offsets", 1, offsets);
  append("UInt8", "types", 1, std::vector<std::uint8_t>(cells, 5));  // VTK's number of a triangle
  close("Cells");
  return "<?xml version=\"1.0\"?>\n<!-- palpate -->\n<VTKFile type=\"UnstructuredGrid\" "
         "version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n"
         "    <Piece NumberOfPoints=\"" +
         std::to_string(surface.vertices.rows()) + "\" NumberOfCells=\"" + std::to_string(cells) +
         "\">\n" + body_ +
         "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _" + data_ +
         "\n  </AppendedData>\n</VTKFile>\n";
}

}  // namespace palpate
