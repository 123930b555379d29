#include "tests/libfem/mesh/read/sample_files.hpp"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace palpate::mesh_read_test {
namespace {

using Rows = std::vector<std::vector<int>>;

template <typename T>
std::string number(double value, bool is_big) {
  const T typed = static_cast<T>(value);
  std::string bytes(reinterpret_cast<const char*>(&typed),
                    sizeof typed);  // tests run on little endian
  if (is_big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <typename T>
std::string numbers(const std::vector<double>& values, bool is_big = false) {
  std::string bytes;
  for (const double value : values) bytes += number<T>(value, is_big);
  return bytes;
}

std::string words(const std::vector<double>& values) {
  std::ostringstream text;
  for (const double value : values) text << value << ' ';
  return text.str();
}

template <typename Matrix>
std::vector<double> flat(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

// Text, a row per line with something before and after.
template <typename Matrix>
std::string lines(const Matrix& matrix, const std::string& before, int add = 0,
                  bool with_id = false, const std::string& after = "") {
  std::ostringstream text;
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    if (with_id) text << r + add << ' ';
    text << before;
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
      text << (c > 0 ? " " : "") << matrix(r, c) + (matrix.cols() == 3 && with_id ? 0 : add);
    text << after << '\n';
  }
  return text.str();
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return text;
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  out.resize(size);
  return out;
}

SampleFile obj() {
  const Surface cube = cube_surface();
  return {"obj", ".obj",
          "# cube\no body\n" + lines(cube.vertices, "v ") + "vn 0 0 1\nvt 0 0\n" +
              lines(cube.triangles, "f ", 1)};
}

SampleFile stl_text() {
  const Surface cube = cube_surface();
  std::ostringstream text;
  text << "solid a cube\n";
  for (Eigen::Index f = 0; f < 12; ++f) {
    text << "facet normal 0 0 0\n outer loop\n";
    for (int k = 0; k < 3; ++k)
      text << "  vertex " << cube.vertices.row(cube.triangles(f, k)) << "\n";
    text << " endloop\nendfacet\n";
  }
  return {"stl_text", ".stl", text.str() + "endsolid a cube\n"};
}

SampleFile stl_binary() {
  const Surface cube = cube_surface();
  // A header that begins like an ASCII file, as some exporters write.
  std::string bytes = "solid" + std::string(75, ' ') + number<std::uint32_t>(12, false);
  for (Eigen::Index f = 0; f < 12; ++f) {
    bytes += numbers<float>({0, 0, 0});
    for (int k = 0; k < 3; ++k)
      bytes += numbers<float>(flat(Vec3(cube.vertices.row(cube.triangles(f, k)))));
    bytes += std::string(2, '\0');
  }
  return {"stl_binary", ".stl", bytes};
}

SampleFile ply(const std::string& encoding) {
  const Surface cube = cube_surface();
  std::string bytes =
      "ply\nformat " + encoding +
      " 1.0\ncomment made here\nelement vertex 8\nproperty double x\nproperty double y\n"
      "property double z\nproperty uchar red\nelement face 12\n"
      "property list uchar int vertex_indices\nend_header\n";
  const bool is_big = encoding == "binary_big_endian";
  if (encoding == "ascii")
    return {"ply_ascii", ".ply",
            bytes + lines(cube.vertices, "", 0, false, " 255") + lines(cube.triangles, "3 ")};
  for (Eigen::Index v = 0; v < 8; ++v)
    bytes += numbers<double>(flat(Vec3(cube.vertices.row(v))), is_big) + '\x7f';
  for (Eigen::Index f = 0; f < 12; ++f)
    bytes += '\3' + numbers<std::int32_t>(flat(Eigen::Vector3i(cube.triangles.row(f))), is_big);
  return {"ply_" + encoding, ".ply", bytes};
}

SampleFile off(bool has_colour) {
  const Surface cube = cube_surface();
  return {has_colour ? "coff" : "off", ".off",
          std::string(has_colour ? "COFF # with colours\n" : "OFF\n") + "# a cube\n8 12 0\n\n" +
              lines(cube.vertices, "", 0, false, has_colour ? " 1 0 0 1" : "") +
              lines(cube.triangles, "3 ", 0, false, has_colour ? " 0.5 0.5 0.5" : "")};
}

std::string vtk_head(bool is_binary, const std::string& dataset) {
  return "# vtk DataFile Version 3.0\na cube\n" + std::string(is_binary ? "BINARY" : "ASCII") +
         "\nDATASET " + dataset + "\nFIELD FieldData 1\ntime 1 1 double\n" +
         (is_binary ? number<double>(0, true) : "0") + "\nPOINTS 8 float\n";
}

template <typename Indices>
std::vector<double> counted(const Indices& cells) {
  std::vector<double> list;
  for (Eigen::Index c = 0; c < cells.rows(); ++c) {
    list.push_back(static_cast<double>(cells.cols()));
    for (Eigen::Index k = 0; k < cells.cols(); ++k) list.push_back(cells(c, k));
  }
  return list;
}

std::vector<double> offsets(Eigen::Index cells, Eigen::Index corners, bool from_zero) {
  std::vector<double> list;
  for (Eigen::Index c = from_zero ? 0 : 1; c <= cells; ++c)
    list.push_back(static_cast<double>(c * corners));
  return list;
}

SampleFile vtk_polydata(bool is_binary) {
  const Surface cube = cube_surface();
  const auto list = counted(cube.triangles);
  std::string bytes = vtk_head(is_binary, "POLYDATA");
  bytes += is_binary ? numbers<float>(flat(cube.vertices), true) : words(flat(cube.vertices));
  bytes += "\nMETADATA\nINFORMATION 0\n\nPOLYGONS 12 48\n";
  bytes += is_binary ? numbers<std::int32_t>(list, true) : words(list);
  return {is_binary ? "vtk_binary" : "vtk_text", ".vtk",
          bytes + "\nPOINT_DATA 8\nSCALARS a float\n"};
}

SampleFile vtk_polydata_5(bool is_binary) {
  const Surface cube = cube_surface();
  std::string bytes = vtk_head(is_binary, "POLYDATA");
  bytes += is_binary ? numbers<float>(flat(cube.vertices), true) : words(flat(cube.vertices));
  const auto begin = offsets(12, 3, true);
  bytes += "\nPOLYGONS 13 36\nOFFSETS vtktypeint64\n";
  bytes += is_binary ? numbers<std::int64_t>(begin, true) : words(begin);
  bytes += "\nCONNECTIVITY vtktypeint64\n";
  bytes +=
      is_binary ? numbers<std::int64_t>(flat(cube.triangles), true) : words(flat(cube.triangles));
  return {is_binary ? "vtk_5_binary" : "vtk_5_text", ".vtk", bytes + "\n"};
}

SampleFile vtk_grid(bool is_binary) {
  const TetMesh cube = cube_tets();
  const auto list = counted(cube.tets);
  const std::vector<double> types(6, 10);
  std::string bytes = vtk_head(is_binary, "UNSTRUCTURED_GRID");
  bytes += is_binary ? numbers<float>(flat(cube.nodes), true) : words(flat(cube.nodes));
  bytes += "\nCELLS 6 30\n";
  bytes += is_binary ? numbers<std::int32_t>(list, true) : words(list);
  bytes += "\nCELL_TYPES 6\n";
  bytes += is_binary ? numbers<std::int32_t>(types, true) : words(types);
  return {is_binary ? "vtk_binary" : "vtk_text", ".vtk", bytes + "\n"};
}

// VTK XML in the ways that its writers offer.
class Xml {
 public:
  enum Way { text, inline_base64, appended_raw, appended_base64, zlib_raw, zlib_inline };
  static constexpr const char* kNames[] = {
      "text", "inline_base64", "appended_raw", "appended_base64", "zlib_raw", "zlib_inline"};
  explicit Xml(Way way) : way_(way) {}

  template <typename T>
  std::string array(const std::string& name, const std::string& type,
                    const std::vector<double>& values, int components = 1) {
    std::string tag = "<DataArray type=\"" + type + "\" Name='" + name + "' NumberOfComponents=\"" +
                      std::to_string(components) + "\" format=\"";
    const std::string bytes = numbers<T>(values);
    const std::string size = number<std::uint32_t>(static_cast<double>(bytes.size()), false);
    switch (way_) {
      case text:
        return tag + "ascii\">\n" + words(values) + "\n</DataArray>\n";
      case inline_base64:
        return tag + "binary\">\n  " + base64(size + bytes) + "\n</DataArray>\n";
      case zlib_inline:
        return tag + "binary\">" + base64(zlib_head(bytes)) + base64(deflated(bytes)) +
               "</DataArray>\n";
      case appended_raw:
        return append(tag, size + bytes);
      case appended_base64:
        return append(tag, base64(size + bytes));
      case zlib_raw:
        return append(tag, zlib_head(bytes) + deflated(bytes));
    }
    return {};
  }

  SampleFile file(const std::string& extension, const std::string& type,
                  const std::string& piece) const {
    const bool is_zlib = way_ == zlib_raw || way_ == zlib_inline;
    std::string bytes = "<?xml version=\"1.0\"?>\n<!-- a cube -->\n<VTKFile type=\"" + type +
                        "\" version=\"0.1\" byte_order=\"LittleEndian\"" +
                        (is_zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<" + type +
                        ">\n" + piece + "</" + type + ">\n";
    if (!appended_.empty())
      bytes += std::string("<AppendedData encoding=\"") +
               (way_ == appended_base64 ? "base64" : "raw") + "\">\n  _" + appended_ +
               "\n</AppendedData>\n";
    return {extension.substr(1) + "_" + kNames[way_], extension, bytes + "</VTKFile>\n"};
  }

 private:
  static std::string zlib_head(const std::string& bytes) {
    const auto size = static_cast<double>(bytes.size());
    return numbers<std::uint32_t>({1, size, size, static_cast<double>(deflated(bytes).size())});
  }
  std::string append(const std::string& tag, const std::string& block) {
    const std::string out =
        tag + "appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
    appended_ += block;
    return out;
  }
  Way way_;
  std::string appended_;
};

SampleFile vtp(Xml::Way way) {
  const Surface cube = cube_surface();
  Xml xml(way);
  std::string piece =
      "<Piece NumberOfPoints=\"8\" NumberOfPolys=\"12\">\n<PointData>" +
      xml.array<float>("value", "Float32", std::vector<double>(8, 1.5)) + "</PointData>\n<Points>" +
      xml.array<float>("Points", "Float32", flat(cube.vertices), 3) + "</Points>\n<Polys>" +
      xml.array<std::int64_t>("connectivity", "Int64", flat(cube.triangles)) +
      xml.array<std::int64_t>("offsets", "Int64", offsets(12, 3, false)) + "</Polys>\n</Piece>\n";
  return xml.file(".vtp", "PolyData", piece);
}

SampleFile vtu(Xml::Way way) {
  const TetMesh cube = cube_tets();
  Xml xml(way);
  std::string piece = "<Piece NumberOfPoints=\"8\" NumberOfCells=\"6\">\n<Points>" +
                      xml.array<double>("Points", "Float64", flat(cube.nodes), 3) +
                      "</Points>\n<Cells>" +
                      xml.array<std::int32_t>("connectivity", "Int32", flat(cube.tets)) +
                      xml.array<std::int32_t>("offsets", "Int32", offsets(6, 4, false)) +
                      xml.array<std::uint8_t>("types", "UInt8", std::vector<double>(6, 10)) +
                      "</Cells>\n</Piece>\n";
  return xml.file(".vtu", "UnstructuredGrid", piece);
}

SampleFile msh_1() {
  const TetMesh cube = cube_tets();
  std::ostringstream elements;
  elements << "1 2 1 1 3 1 2 3\n";  // a triangle
  for (Eigen::Index t = 0; t < 6; ++t)
    elements << t + 2 << " 4 1 1 4 " << (cube.tets.row(t).array() + 1) << "\n";
  return {"msh_1", ".msh",
          "$NOD\n8\n" + lines(cube.nodes, "", 1, true) + "$ENDNOD\n$ELM\n7\n" + elements.str() +
              "$ENDELM\n"};
}

SampleFile msh_2(bool is_binary) {
  const TetMesh cube = cube_tets();
  std::string bytes = "$MeshFormat\n2.2 " + std::string(is_binary ? "1" : "0") + " 8\n";
  if (is_binary) bytes += number<std::int32_t>(1, false) + "\n";
  bytes += "$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"body\"\n$EndPhysicalNames\n$Nodes\n8\n";
  if (!is_binary) {
    std::ostringstream elements;
    for (Eigen::Index t = 0; t < 6; ++t)
      elements << t + 1 << " 4 2 1 1 " << (cube.tets.row(t).array() + 1) << "\n";
    return {"msh_2_text", ".msh",
            bytes + lines(cube.nodes, "", 1, true) + "$EndNodes\n$Elements\n6\n" + elements.str() +
                "$EndElements\n"};
  }
  for (Eigen::Index n = 0; n < 8; ++n)
    bytes += number<std::int32_t>(static_cast<double>(n + 1), false) +
             numbers<double>(flat(Vec3(cube.nodes.row(n))));
  bytes += "\n$EndNodes\n$Elements\n6\n" + numbers<std::int32_t>({4, 6, 2});
  for (Eigen::Index t = 0; t < 6; ++t)
    bytes += numbers<std::int32_t>({static_cast<double>(t + 1), 1, 1}) +
             numbers<std::int32_t>(flat(Eigen::Vector4i(cube.tets.row(t).array() + 1)));
  return {"msh_2_binary", ".msh", bytes + "\n$EndElements\n"};
}

SampleFile msh_4(bool is_binary) {
  const TetMesh cube = cube_tets();
  const std::string head = "$MeshFormat\n4.1 " + std::string(is_binary ? "1" : "0") + " 8\n";
  const std::vector<double> tags{11, 12, 13, 14, 15, 16, 17, 18};  // tags need not begin with 1
  if (!is_binary) {
    std::ostringstream elements;
    for (Eigen::Index t = 0; t < 6; ++t)
      elements << t + 1 << " " << (cube.tets.row(t).array() + 11) << "\n";
    return {"msh_4_text", ".msh",
            head + "$EndMeshFormat\n$Nodes\n1 8 11 18\n3 1 0 8\n" + words(tags) + "\n" +
                lines(cube.nodes, "") + "$EndNodes\n$Elements\n1 6 1 6\n3 1 4 6\n" +
                elements.str() + "$EndElements\n"};
  }
  std::string bytes = head + number<std::int32_t>(1, false) + "\n$EndMeshFormat\n$Nodes\n" +
                      numbers<std::uint64_t>({1, 8, 11, 18}) + numbers<std::int32_t>({3, 1, 0}) +
                      number<std::uint64_t>(8, false) + numbers<std::uint64_t>(tags) +
                      numbers<double>(flat(cube.nodes)) + "\n$EndNodes\n$Elements\n" +
                      numbers<std::uint64_t>({1, 6, 1, 6}) + numbers<std::int32_t>({3, 1, 4}) +
                      number<std::uint64_t>(6, false);
  for (Eigen::Index t = 0; t < 6; ++t)
    bytes += number<std::uint64_t>(static_cast<double>(t + 1), false) +
             numbers<std::uint64_t>(flat(Eigen::Vector4i(cube.tets.row(t).array() + 11)));
  return {"msh_4_binary", ".msh", bytes + "\n$EndElements\n"};
}

SampleFile tetgen(bool is_node_given) {
  const TetMesh cube = cube_tets();
  const std::string node = "# nodes\n8 3 0 1\n" + lines(cube.nodes, "", 1, true, " 1");
  std::ostringstream ele;
  ele << "6 4 0\n";
  for (Eigen::Index t = 0; t < 6; ++t)
    ele << t + 1 << " " << (cube.tets.row(t).array() + 1) << "\n";
  ele << "# made here\n";
  return is_node_given ? SampleFile{"tetgen_node", ".node", node, ".ele", ele.str()}
                       : SampleFile{"tetgen_ele", ".ele", ele.str(), ".node", node};
}

}  // namespace

Surface cube_surface() {
  Surface cube;
  cube.vertices = cube_tets().nodes;
  cube.triangles.resize(12, 3);
  cube.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6,  // z
      0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,                // y
      0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5;                // x
  return cube;
}

TetMesh cube_tets() {
  TetMesh cube;
  cube.nodes.resize(8, 3);
  for (int v = 0; v < 8; ++v) cube.nodes.row(v) << (v & 1), (v >> 1 & 1), (v >> 2 & 1);
  cube.tets.resize(6, 4);  // Kuhn's: paths from corner 0 to corner 7
  cube.tets << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
  return cube;
}

std::vector<SampleFile> surface_samples() {
  std::vector<SampleFile> samples{obj(),
                                  stl_text(),
                                  stl_binary(),
                                  ply("ascii"),
                                  ply("binary_little_endian"),
                                  ply("binary_big_endian"),
                                  off(false),
                                  off(true),
                                  vtk_polydata(false),
                                  vtk_polydata(true),
                                  vtk_polydata_5(false),
                                  vtk_polydata_5(true)};
  for (int way = Xml::text; way <= Xml::zlib_inline; ++way) samples.push_back(vtp(Xml::Way(way)));
  return samples;
}

std::vector<SampleFile> tet_samples() {
  std::vector<SampleFile> samples{msh_1(),        msh_2(false), msh_2(true),
                                  msh_4(false),   msh_4(true),  vtk_grid(false),
                                  vtk_grid(true), tetgen(true), tetgen(false)};
  for (int way = Xml::text; way <= Xml::zlib_inline; ++way) samples.push_back(vtu(Xml::Way(way)));
  return samples;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "palpate_mesh_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::write(const std::string& name,
                                             const std::string& bytes) const {
  std::ofstream(path_ / name, std::ios::binary) << bytes;
  return path_ / name;
}

std::filesystem::path TemporaryFolder::write(const SampleFile& sample) const {
  if (!sample.sibling_extension.empty()) write("mesh" + sample.sibling_extension, sample.sibling);
  return write("mesh" + sample.extension, sample.bytes);
}

}  // namespace palpate::mesh_read_test
