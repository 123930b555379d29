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

}  // namespace palpate
