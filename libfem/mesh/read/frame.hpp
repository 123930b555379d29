#pragma once

#include <filesystem>
#include <string>

namespace palpate {

/// The anatomical frame that a mesh file states for its coordinates, LPS (x to the left, y to the
/// back, z to the head) or RAS (x to the right, y to the front); empty where it states none.
/// 3D Slicer writes `SPACE=LPS` into the header of STL, into the title of legacy VTK and into
/// comments of OBJ and PLY, and a text `SPACE` into the field data of VTP and VTU.
/// Throws Error when the file cannot be read.
std::string stated_frame(const std::filesystem::path& mesh_file);

}  // namespace palpate
