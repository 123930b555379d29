#pragma once

#include <filesystem>

#include "libfem/mesh/read/raw_mesh.hpp"

/// One reader per format, each in its own .cpp. A reader gets a cursor at the start of the file's
/// bytes and fills a raw mesh, or throws Error naming the place. All are safe on untrusted bytes.
namespace palpate::mesh_read {

RawSurface read_obj(Cursor& file);
RawSurface read_stl(Cursor& file);
RawSurface read_ply(Cursor& file);
RawSurface read_off(Cursor& file);
RawSurface read_vtk_polydata(Cursor& file);
RawSurface read_vtp(Cursor& file);

RawTetMesh read_msh(Cursor& file);
RawTetMesh read_vtk_grid(Cursor& file);
RawTetMesh read_vtu(Cursor& file);
/// Either of the pair X.node, X.ele; opens the other beside it.
RawTetMesh read_tetgen(Cursor& file);

}  // namespace palpate::mesh_read
