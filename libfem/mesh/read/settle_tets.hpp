#pragma once

#include <string>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfem/mesh/read/read.hpp"

namespace palpate::mesh_read {

/// A tet mesh in m from a reader's raw one: unused nodes dropped, negative tets turned.
/// where: the file, for messages. Throws Error when tets have no volume or use a node twice, or two
/// tets lie on the same side of a shared face (they overlap), or three share one.
TetMesh settle_tets(const RawTetMesh& raw, double length_unit_m, const std::string& where,
                    TetReadNotes& notes);

}  // namespace palpate::mesh_read
