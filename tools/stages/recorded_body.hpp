#pragma once

#include "libfem/mesh/surface/surface.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "tools/manifest/manifest.hpp"

namespace palpate::tools {

/// The surface that the points of recordings lie on; how far contacts left out lie off it is said
/// on stderr. Throws Error where the contacts make none.
ContactSurface surface_of_contacts(const Samples& samples);

/// OBJ in mm, with the unit in its first line.
std::string obj_text(const Surface& surface);

/// The body of recordings: the manifest's surface, else the one of their contacts, with curves
/// wanted wherever a point answers; test points are the samples'. No volume.
Body body_of_recordings(const Manifest& manifest, const Samples& samples);

}  // namespace palpate::tools
