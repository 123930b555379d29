#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// The doubt, a sentence with the unit that would be likelier, where a mesh measures what few
/// organs do: less than 4 cm or more than 60 cm. extent: in the file's unit, which is unit_m long.
std::optional<std::string> doubt_of_size(const Vec3& extent, double unit_m);

/// The doubt of a lid: a surface that mending had to close over an opening half as wide as the body
/// or more. in_file: as it was read, scaled to m; changes: what mending said of it.
std::optional<std::string> doubt_of_lid(const Surface& in_file,
                                        const std::vector<std::string>& changes);

/// What `check` doubts of a scene's body file: its lid, and a wrap that was not needed.
std::vector<std::string> doubts_of_body(const Scene& scene,
                                        const std::vector<std::string>& changes);

}  // namespace palpate::tools
