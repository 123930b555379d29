#pragma once

#include "libfem/materials/materials.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

/// The material of a table: `law`, and the keys of that law's parameter rows. Returns a value for
/// every row, SI; NaN for an optional one left out. may_relax: the keys
/// `relaxation` and `softening` are among them.
/// Throws Error with file:line:column for an unknown law or key (naming the nearest), a key missing
/// or of the wrong kind or unit, two keys that exclude each other, and values that the law refuses.
fem::MaterialParameters read_material(SceneTable table, bool may_relax = false);

}  // namespace palpate::tools
