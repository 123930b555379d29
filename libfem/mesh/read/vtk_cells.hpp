#pragma once

#include <cstdint>
#include <vector>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {

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
