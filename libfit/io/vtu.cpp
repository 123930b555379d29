#include "libfit/io/vtu.hpp"

#include <fmt/core.h>

#include "libfit/io/atomic_file.hpp"

namespace palpate {

std::string VtuWriter::text(const Surface& surface, const std::string& scalars) {
  close("PointData", scalars.empty() ? "" : " Scalars=\"" + scalars + "\"");
  const auto* places = surface.vertices.data();
  add("Points", 3, std::vector<double>(places, places + surface.vertices.size()));
  close("Points");
  const bool is_cloud = surface.triangles.rows() == 0;
  const auto* corners = surface.triangles.data();
  std::vector<std::int32_t> connectivity(corners, corners + surface.triangles.size());
  for (std::int32_t v = 0; is_cloud && v < surface.vertices.rows(); ++v) connectivity.push_back(v);
  const int width = is_cloud ? 1 : 3;
  const auto cells = static_cast<std::int64_t>(connectivity.size()) / width;
  std::vector<std::int64_t> offsets;
  for (std::int64_t t = 1; t <= cells; ++t) offsets.push_back(width * t);
  append("Int32", "connectivity", 1, connectivity);
  append("Int64", "offsets", 1, offsets);
  // VTK's numbers of a vertex and of a triangle.
  append("UInt8", "types", 1, std::vector<std::uint8_t>(offsets.size(), is_cloud ? 1 : 5));
  close("Cells");
  return "<?xml version=\"1.0\"?>\n<!-- palpate -->\n<VTKFile type=\"UnstructuredGrid\" "
         "version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n" +
         (fields_.empty() ? "" : "    <FieldData>\n" + fields_ + "    </FieldData>\n") +
         "    <Piece NumberOfPoints=\"" + std::to_string(surface.vertices.rows()) +
         "\" NumberOfCells=\"" + std::to_string(cells) + "\">\n" + body_ +
         "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _" + data_ +
         "\n  </AppendedData>\n</VTKFile>\n";
}

void VtuSeries::add(double time_s, const std::string& part, int number, const std::string& text) {
  const std::string name = fmt::format("{}_{:06}.vtu", part, number);
  write_file_atomically(folder_ / name, text);
  entries_ += fmt::format("    <DataSet timestep=\"{}\" part=\"{}\" file=\"{}\"/>\n", time_s,
                          part == "surface" ? 0 : 1, name);
}

void VtuSeries::close() const {
  write_file_atomically(
      folder_ / "path.pvd",
      "<?xml version=\"1.0\"?>\n<!-- palpate -->\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n  <Collection>\n" +
          entries_ + "  </Collection>\n</VTKFile>\n");
}

}  // namespace palpate
