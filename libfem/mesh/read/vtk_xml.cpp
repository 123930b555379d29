// VTP (surfaces) and VTU (tet meshes) of VTK, one or several pieces.
#include <string>

#include "libfem/mesh/read/formats.hpp"
#include "libfem/mesh/read/vtk_cells.hpp"
#include "libfem/mesh/read/vtk_xml_file.hpp"

namespace palpate::mesh_read {
namespace {

void append_points(const VtkXmlFile& xml, const VtkPiece& piece, const Cursor& file,
                   std::vector<Vec3>& points) {
  if (piece.points == 0) return;
  const std::vector<double> xyz = xml.reals(piece, "Points", "", 3 * piece.points);
  for (std::size_t i = 0; i < xyz.size(); ++i)
    if (const std::string fault = coordinate_fault(xyz[i]); !fault.empty())
      file.fail(fault + " in point " + std::to_string(i / 3));
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3)
    points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
}

VtkCells read_cells(const VtkXmlFile& xml, const VtkPiece& piece, const char* section,
                    std::int64_t number) {
  if (number == 0) return {};
  return {xml.integers(piece, section, "offsets", number),
          xml.integers(piece, section, "connectivity", -1)};
}

// Values on points and cells of a piece, behind those of the pieces before it.
void append_fields(const VtkXmlFile& xml, const VtkPiece& piece, RawLabels& labels) {
  for (const VtkArray& array : piece.arrays) {
    const bool is_on_points = array.section == "PointData";
    if (!is_on_points && array.section != "CellData") continue;
    std::vector<double>& all = labels.field(array.name, is_on_points).values;
    const std::vector<double> here = xml.reals(piece, array.section, array.name, -1);
    all.insert(all.end(), here.begin(), here.end());
  }
}

}  // namespace

RawSurface read_vtp(Cursor& file, RawLabels* labels) {
  const VtkXmlFile xml(file, "PolyData");
  RawSurface surface;
  for (const VtkPiece& piece : xml.pieces()) {
    const std::size_t base = surface.points.size();
    append_points(xml, piece, file, surface.points);
    const VtkCells polygons = read_cells(xml, piece, "Polys", piece.polys),
                   strips = read_cells(xml, piece, "Strips", piece.strips);
    add_polygons(surface, polygons, base, file);
    add_strips(surface, strips, base, file);
    if (labels == nullptr) continue;
    labels->cells += static_cast<std::int32_t>(piece.verts + piece.lines);
    note_cells(polygons, *labels);
    note_cells(strips, *labels);
    append_fields(xml, piece, *labels);
  }
  return surface;
}

RawTetMesh read_vtu(Cursor& file, RawLabels* labels) {
  const VtkXmlFile xml(file, "UnstructuredGrid");
  RawTetMesh mesh;
  for (const VtkPiece& piece : xml.pieces()) {
    const std::size_t base = mesh.points.size();
    append_points(xml, piece, file, mesh.points);
    if (piece.cells == 0) continue;
    add_tets(mesh, read_cells(xml, piece, "Cells", piece.cells),
             xml.integers(piece, "Cells", "types", piece.cells), base, file, labels);
    if (labels != nullptr) append_fields(xml, piece, *labels);
  }
  return mesh;
}

}  // namespace palpate::mesh_read
