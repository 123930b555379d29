#include "tests/libfem/mesh/read/sample_files.hpp"

#include <algorithm>
#include <cstdint>
#include <sstream>

#include "tests/support/surfaces.hpp"

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

template <typename T>
std::string big_or_words(bool is_binary, const std::vector<double>& values) {
  return is_binary ? numbers<T>(values, true) : words(values);
}

std::string vtk_head(bool is_binary, const std::string& dataset) {
  return "# vtk DataFile Version 3.0\na cube\n" + std::string(is_binary ? "BINARY" : "ASCII") +
         "\nDATASET " + dataset + "\nFIELD FieldData 1\ntime 1 1 double\n" +
         (is_binary ? number<double>(0, true) : "0") + "\nPOINTS 8 float\n" +
         big_or_words<float>(is_binary, flat(cube_tets().nodes));
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
  return {is_binary ? "vtk_binary" : "vtk_text", ".vtk",
          vtk_head(is_binary, "POLYDATA") + "\nMETADATA\nINFORMATION 0\n\nPOLYGONS 12 48\n" +
              big_or_words<std::int32_t>(is_binary, counted(cube.triangles)) +
              "\nPOINT_DATA 8\nSCALARS a float\n"};
}

SampleFile vtk_polydata_5(bool is_binary) {
  const Surface cube = cube_surface();
  std::string bytes = vtk_head(is_binary, "POLYDATA");
  const auto begin = offsets(12, 3, true);
  bytes += "\nPOLYGONS 13 36\nOFFSETS vtktypeint64\n";
  bytes += big_or_words<std::int64_t>(is_binary, begin);
  bytes += "\nCONNECTIVITY vtktypeint64\n";
  bytes += big_or_words<std::int64_t>(is_binary, flat(cube.triangles));
  return {is_binary ? "vtk_5_binary" : "vtk_5_text", ".vtk", bytes + "\n"};
}

SampleFile vtk_grid(bool is_binary) {
  const TetMesh cube = cube_tets();
  const auto list = counted(cube.tets);
  const std::vector<double> types(6, 10);
  std::string bytes = vtk_head(is_binary, "UNSTRUCTURED_GRID");
  bytes += "\nCELLS 6 30\n";
  bytes += big_or_words<std::int32_t>(is_binary, list);
  bytes += "\nCELL_TYPES 6\n";
  bytes += big_or_words<std::int32_t>(is_binary, types);
  return {is_binary ? "vtk_binary" : "vtk_text", ".vtk", bytes + "\n"};
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

// Bytes of an MSH file, as text or binary.
class MshBytes {
 public:
  explicit MshBytes(bool is_binary) : is_binary_(is_binary) {}
  MshBytes& text(const std::string& words) { return out += words, *this; }
  MshBytes& small(std::int32_t value) { return put(value); }
  MshBytes& large(std::int64_t value) { return put(value); }
  MshBytes& real(double value) { return put(value); }
  std::string out;

 private:
  template <class Value>
  MshBytes& put(Value value) {
    out +=
        is_binary_ ? number<Value>(static_cast<double>(value), false) : std::to_string(value) + " ";
    return *this;
  }
  bool is_binary_;
};

SampleFile msh(double version, bool is_binary) {
  return {std::string(version > 4 ? "msh_4" : "msh_2") + (is_binary ? "_binary" : "_text"), ".msh",
          marked_msh(version, is_binary)};
}

}  // namespace

Surface cube_surface() { return testing_support::cube(1); }

TetMesh cube_tets() {
  TetMesh cube;
  cube.nodes.resize(8, 3);
  for (int v = 0; v < 8; ++v) cube.nodes.row(v) << (v & 1), (v >> 1 & 1), (v >> 2 & 1);
  cube.tets.resize(6, 4);  // Kuhn's: paths from corner 0 to corner 7
  cube.tets << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
  return cube;
}

std::vector<SampleFile> surface_samples() {
  return {obj(),
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
}

std::vector<SampleFile> tet_samples() {
  return {msh_1(),        msh(2.2, false), msh(2.2, true), msh(4.1, false),
          msh(4.1, true), vtk_grid(false), vtk_grid(true)};
}

Triangles top_faces() {
  Triangles faces(2, 3);
  faces << 6, 4, 7, 4, 5, 7;
  return faces;
}

std::string marked_msh(double version, bool is_binary) {
  const TetMesh cube = cube_tets();
  MshBytes file(is_binary);
  file.text(version > 4 ? "$MeshFormat\n4.1 " : "$MeshFormat\n2.2 ")
      .text(is_binary ? "1 8\n" : "0 8\n");
  if (is_binary) file.small(1).text("\n");
  file.text(
      "$EndMeshFormat\n$PhysicalNames\n3\n2 5 \"upper side\"\n3 1 \"body\"\n3 2 \"lump\"\n"
      "$EndPhysicalNames\n");
  int id = 1;
  if (version > 4) {
    constexpr int kFirst = 11;  // tags need not begin with 1
    file.text("$Entities\n").large(1).large(0).large(1).large(2);
    file.small(1).real(0).real(0).real(0).large(0);
    file.small(1);
    for (int k = 0; k < 6; ++k) file.real(k > 2);
    file.large(1).small(5).large(2).small(1).small(-2);
    for (const int volume : {1, 2}) {
      file.small(volume);
      for (int k = 0; k < 6; ++k) file.real(k > 2);
      file.large(1).small(volume).large(0);
    }
    file.text("\n$EndEntities\n$Nodes\n").large(1).large(8).large(kFirst).large(kFirst + 7);
    file.small(3).small(1).small(0).large(8);
    for (int v = 0; v < 8; ++v) file.large(kFirst + v);
    for (const auto& p : cube.nodes.rowwise()) file.real(p[0]).real(p[1]).real(p[2]);
    file.text("\n$EndNodes\n$Elements\n").large(3).large(8).large(1).large(8);
    const auto elements = [&](int dimension, int entity, int type, const auto& corners) {
      file.small(dimension).small(entity).small(type).large(corners.rows());
      for (const auto& row : corners.rowwise()) {
        file.large(id++);
        for (const int v : row) file.large(kFirst + v);
      }
    };
    elements(2, 1, 2, top_faces());
    elements(3, 2, 4, Tets(cube.tets.topRows(3)));
    elements(3, 1, 4, Tets(cube.tets.bottomRows(3)));
    return file.text("\n$EndElements\n").out;
  }
  file.text("$Nodes\n8\n");
  for (int v = 0; v < 8; ++v) {
    file.small(v + 1);
    for (int k = 0; k < 3; ++k) file.real(cube.nodes(v, k));
  }
  file.text("\n$EndNodes\n$Elements\n8\n");
  const auto elements = [&](int type, int physical, const auto& corners) {
    if (is_binary) file.small(type).small(static_cast<int>(corners.rows())).small(2);
    for (const auto& row : corners.rowwise()) {
      file.small(id++);
      if (!is_binary) file.small(type).small(2);
      file.small(physical).small(9);
      for (const int v : row) file.small(v + 1);
    }
  };
  elements(2, 5, top_faces());
  elements(4, 2, Tets(cube.tets.topRows(3)));
  elements(4, 1, Tets(cube.tets.bottomRows(3)));
  return file.text("\n$EndElements\n").out;
}

std::filesystem::path MeshFiles::write(const std::string& name, const std::string& bytes) const {
  testing_io::write_quickly(at(name), bytes);
  return at(name);
}

std::filesystem::path MeshFiles::write(const SampleFile& sample) const {
  return write("mesh" + sample.extension, sample.bytes);
}

}  // namespace palpate::mesh_read_test
