#pragma once

#include <cstdint>
#include <filesystem>
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
  /// Field data: numbers of the whole file. ParaView takes "TimeValue" for its time.
  void add_field(const std::string& name, const std::vector<double>& values) {
    append("Float64", name, static_cast<int>(values.size()), values, &fields_,
           " NumberOfTuples=\"1\"");
  }
  /// The whole file. scalars: name of what a viewer shows first. Without triangles, a cloud
  /// of points.
  std::string text(const Surface& surface, const std::string& scalars);

 private:
  template <class T>
  void append(const char* type, const std::string& name, int components,
              const std::vector<T>& values, std::string* list = nullptr,
              const std::string& more = {}) {
    (list ? *list : arrays_) += "        <DataArray type=\"" + std::string(type) + "\" Name=\"" +
                                name + "\" NumberOfComponents=\"" + std::to_string(components) +
                                "\"" + more + " format=\"appended\" offset=\"" +
                                std::to_string(data_.size()) + "\"/>\n";
    const std::uint64_t bytes = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }
  void close(const std::string& element, const std::string& attributes = {}) {
    body_ += "      <" + element + attributes + ">\n" + arrays_ + "      </" + element + ">\n";
    arrays_.clear();
  }

  std::string arrays_, fields_, body_, data_;
};

/// A time series of .vtu files and the path.pvd that names them. Source: ParaView, "PVD File
/// Format".
class VtuSeries {
 public:
  explicit VtuSeries(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Writes FOLDER/<part>_<number>.vtu; the folder must exist. part: tells what belongs to one time
  /// from each other.
  void add(double time_s, const std::string& part, int number, const std::string& text);
  /// Writes FOLDER/path.pvd.
  void close() const;

 private:
  std::filesystem::path folder_;
  std::string entries_;
};

}  // namespace palpate
