#include "libfit/io/vtu.hpp"

#include <fmt/core.h>

#include "libfit/io/atomic_file.hpp"

namespace palpate {

std::string VtuWriter::text(const Surface& surface, const std::string& scalars) {
  close("PointData", " Scalars=\"" + scalars + "\"");
  const auto* places = surface.vertices.data();
  add("Points", 3, std::vector<double>(places, places + surface.vertices.size()));
  close("Points");
  const auto* corners = surface.triangles.data();
  std::vector<std::int64_t> offsets;
  for (Eigen::Index t = 1; t <= surface.triangles.rows(); ++t) offsets.push_back(3 * t);
  append("Int32", "connectivity", 1,
         std::vector<std::int32_t>(corners, corners + surface.triangles.size()));
  append("Int64", "offsets", 1, offsets);
  append("UInt8", "types", 1, std::vector<std::uint8_t>(offsets.size(), 5));  // VTK_TRIANGLE
  close("Cells");
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n" +
         (fields_.empty() ? "" : "    <FieldData>\n" + fields_ + "    </FieldData>\n") +
         "    <Piece NumberOfPoints=\"" + std::to_string(surface.vertices.rows()) +
         "\" NumberOfCells=\"" + std::to_string(surface.triangles.rows()) + "\">\n" + body_ +
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
  write_file_atomically(folder_ / "path.pvd",
                        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
                        "byte_order=\"LittleEndian\">\n  <Collection>\n" +
                            entries_ + "  </Collection>\n</VTKFile>\n");
}

}  // namespace palpate
