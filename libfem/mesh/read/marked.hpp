#pragma once

#include <filesystem>
#include <string>

#include "libfem/mesh/read/painted_part.hpp"

namespace palpate {

/// A part of a mesh by what its file says of it: a group (MSH physical group, OBJ `g`, `o` or
/// `usemtl`), a colour ("#ff0000", of the faces or vertices of a PLY), or the points or cells whose
/// field (VTK, VTU, VTP, PLY property) equals a number.
struct MeshMark {
  enum class By { group, colour, field };
  By by = By::group;
  std::string name;
  double equals = 0;  ///< of a field
};

/// The mesh of a file in m, and which part of it has the mark: triangles of a surface; of a file of
/// tets the tets that have it, else the boundary triangles.
/// Formats, limits and safety as read_surface and read_tet_mesh. Throws Error also where the file
/// has no such group, colour or field, and lists those that it has, or nothing has the mark.
PaintedPart read_marked_part(const std::filesystem::path& path, double length_unit_m, bool is_tets,
                             const MeshMark& mark);

}  // namespace palpate
