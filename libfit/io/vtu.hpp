#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Data on a surface as a VTK XML UnstructuredGrid (.vtu), appended raw: each block is its byte
/// count (UInt64), then bytes. Source: VTK file formats, "XML File Formats".
class VtuWriter {
 public:
  /// Values by vertex, `components` a vertex.
  void add(const std::string& name, int components, const std::vector<char>& values) {
    append("UInt8", name, components, values);
  }
  void add(const std::string& name, int components, const std::vector<float>& values) {
    append("Float32", name, components, values);
  }
  void add(const std::string& name, int components, const std::vector<double>& values) {
    append("Float64", name, components, values);
  }
  /// The whole file. scalars: name of what a viewer shows first, or empty.
  std::string text(const Surface& surface, const std::string& scalars);

 private:
  template <class T>
  void append(const char* type, const std::string& name, int components,
              const std::vector<T>& values) {
    arrays_ += "        <DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
               "\" NumberOfComponents=\"" + std::to_string(components) +
               "\" format=\"appended\" offset=\"" + std::to_string(data_.size()) + "\"/>\n";
    const std::uint64_t bytes = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }
  void close(const std::string& element, const std::string& attributes = {}) {
    body_ += "      <" + element + attributes + ">\n" + arrays_ + "      </" + element + ">\n";
    arrays_.clear();
  }

  std::string arrays_, body_, data_;
};

inline std::string VtuWriter::text(const Surface& surface, const std::string& scalars) {
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
