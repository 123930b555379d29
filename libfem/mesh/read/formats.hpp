#pragma once

#include <filesystem>

#include "libfem/mesh/read/raw_mesh.hpp"

/// One reader per format, each in its own .cpp. A reader gets a cursor at the start of the file's
/// bytes and fills a raw mesh, or throws Error naming the place. All are safe on untrusted bytes.
/// labels: what else the file says, where its format has such (OBJ, PLY, VTK, MSH); null: passed
/// over, so that nothing in it is refused.
namespace palpate::mesh_read {

RawSurface read_obj(Cursor& file, RawLabels* labels);
RawSurface read_stl(Cursor& file, RawLabels* labels);
RawSurface read_ply(Cursor& file, RawLabels* labels);
RawSurface read_off(Cursor& file, RawLabels* labels);
RawSurface read_vtk_polydata(Cursor& file, RawLabels* labels);
RawSurface read_vtp(Cursor& file, RawLabels* labels);

RawTetMesh read_msh(Cursor& file, RawLabels* labels);
RawTetMesh read_vtk_grid(Cursor& file, RawLabels* labels);
RawTetMesh read_vtu(Cursor& file, RawLabels* labels);
/// Either of the pair X.node, X.ele; opens the other beside it.
RawTetMesh read_tetgen(Cursor& file, RawLabels* labels);

}  // namespace palpate::mesh_read
