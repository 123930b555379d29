#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "libfem/mesh/read/cursor.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::mesh_read {

/// Result of a surface reader, in file units. Corners index `points` (checked by the reader, or by
/// add_polygon).
struct RawSurface {
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

/// Result of a tet reader, in file units. tet_id: the file's own number of each tet, for messages.
struct RawTetMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 4>> tets;
  std::vector<std::int64_t> tet_id;
  std::size_t ignored_elements = 0;
};

/// Fields and groups of a file's points and cells. A reader fills it where it is
/// asked to; cells are counted as the file counts them, from 0.
struct RawLabels {
  struct Field {
    std::string name;
    bool is_on_points = false;
    std::vector<double> values;  ///< one row after another, of each point or cell
  };
  struct Group {
    std::string name;
    int dimension = 2;
    std::vector<std::int32_t> cells;
  };
  std::vector<Field> fields;
  std::vector<Group> groups;
  std::int32_t cells = 0;
  std::vector<std::int32_t> cell;                  ///< that each triangle or tet is made of
  std::vector<std::array<std::int32_t, 3>> faces;  ///< triangles in a file of tets
  std::vector<std::int32_t> face_cell;

  /// Counts a cell that the last `triangles` of a surface were made of.
  void add_cell(std::size_t triangles) { cell.insert(cell.end(), triangles, cells++); }
  /// Notes a triangle of a file of tets.
  void add_face(std::span<const std::int64_t> corners, std::int32_t of_cell);

  /// The field or group of this name, made where there is none.
  Field& field(std::string_view name, bool is_on_points);
  Group& group(std::string_view name, int dimension);
};

/// Adds a polygon as a fan about its first corner. corners: indices into `points`, at least 3.
/// Throws through `cursor` (which says where) when there are fewer or one is out of range.
void add_polygon(RawSurface& surface, std::span<const std::int64_t> corners, const Cursor& cursor);

/// Adds a tet by its four corner indices, checked as in add_polygon.
void add_tet(RawTetMesh& mesh, std::span<const std::int64_t, 4> corners, std::int64_t id,
             const Cursor& cursor);

/// The element kinds that share a file with tets.
[[noreturn]] void fail_not_tets(const Cursor& cursor, const char* kind);

/// The mesh of a file by its extension, in file units; labels: null, or what else it says.
RawSurface read_raw_surface(const std::filesystem::path& path, RawLabels* labels);
RawTetMesh read_raw_tets(const std::filesystem::path& path, RawLabels* labels);

/// A tet mesh in m from a reader's raw one: unused nodes and duplicate tets dropped, negative tets
/// turned.
/// where: the file, for messages. Throws Error when tets have no volume or use a node twice, or two
/// tets lie on the same side of a shared face (they overlap), or three share one.
TetMesh settle_tets(RawTetMesh raw, double length_unit_m, const std::string& where,
                    TetReadNotes& notes);

// One reader per format, each in its own .cpp. A reader gets a cursor at the start of the file's
// bytes and fills a raw mesh, or throws Error naming the place. All are safe on untrusted bytes.
// labels: what else the file says, where its format has such (OBJ, PLY, VTK, MSH); null: passed
// over, so that nothing in it is refused.

RawSurface read_obj(Cursor& file, RawLabels* labels);
RawSurface read_stl(Cursor& file, RawLabels* labels);
RawSurface read_ply(Cursor& file, RawLabels* labels);
RawSurface read_off(Cursor& file, RawLabels* labels);
RawSurface read_vtk_polydata(Cursor& file, RawLabels* labels);
RawSurface read_vtp(Cursor& file, RawLabels* labels);

RawTetMesh read_msh(Cursor& file, RawLabels* labels);
RawTetMesh read_vtk_grid(Cursor& file, RawLabels* labels);
RawTetMesh read_vtu(Cursor& file, RawLabels* labels);
/// The first text of the array `name` in the field data of a VTK XML file of a type, PolyData or
/// UnstructuredGrid; empty where it has none.
std::string vtk_field_text(Cursor& file, std::string_view type, std::string_view name);
/// Either of the pair X.node, X.ele; opens the other beside it.
RawTetMesh read_tetgen(Cursor& file, RawLabels* labels);

/// Cells as VTK keeps them: cell i has corners connectivity[end[i-1] .. end[i]), end[-1] = 0.
struct VtkCells {
  std::vector<std::int64_t> end;
  std::vector<std::int64_t> connectivity;
};

/// Adds polygons as fans; point indices start at `base` of the mesh's points.
/// These throw through `cursor` when offsets fall or overrun, or indices are out of range.
void add_polygons(RawSurface& surface, const VtkCells& cells, std::size_t base,
                  const Cursor& cursor);

/// Adds triangle strips: every second triangle is turned.
void add_strips(RawSurface& surface, const VtkCells& cells, std::size_t base, const Cursor& cursor);

/// Notes for each polygon or strip that it is the labels' next cell, and its triangles of it.
void note_cells(const VtkCells& cells, RawLabels& labels);

/// Adds the tets among cells of the given VTK types (10; 24, 71 by their corners), counts points,
/// lines and faces as ignored, and throws when there are other volumes. labels: may be null.
void add_tets(RawTetMesh& mesh, const VtkCells& cells, const std::vector<std::int64_t>& types,
              std::size_t base, const Cursor& cursor, RawLabels* labels);

}  // namespace palpate::mesh_read
