#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::bodies {

/// A body that ships with Palpate, in mm as its file is.
struct NamedBody {
  const char* file;
  Surface (*make_mm)();
};

/// A liver: right lobe towards +x, anterior +y, superior +z, about 190 x 150 x 110 mm. A dome cut
/// from below by an arched visceral face, with a thin inferior edge, a groove for the spine and
/// a notch for the gallbladder. No patient's: an implicit surface, meshed.
Surface liver_mm();

/// The paper's cylinder: radius 30 mm, axis z from 0 to 100 mm, flat caps, 5 mm triangles.
Surface cylinder_mm();

/// A block 100 x 100 x 40 mm with a corner at the origin, sharp edges, 5 mm triangles.
Surface block_mm();

/// A clot on a plate: a cap on z = 0, 60 x 51 mm and 16 mm high, 3 mm triangles.
Surface clot_mm();

/// A breast on the chest wall z = -20, fuller towards -y: an implicit surface, meshed.
Surface breast_mm();

/// A finger that lies along own x: the hull of balls of 6, 5 and 4 mm, -10, 1 and 10 mm along it. A
/// tool, and no body.
Surface finger_mm();

inline constexpr NamedBody kBodies[] = {{"block.obj", block_mm},   {"breast.obj", breast_mm},
                                        {"clot.obj", clot_mm},     {"cylinder.obj", cylinder_mm},
                                        {"finger.obj", finger_mm}, {"liver.obj", liver_mm}};

/// What is true of a body's mesh as its file has it; lengths in mm.
struct BodyFacts {
  Vec3 extent_mm;
  double volume_ml = 0;
  double area_cm2 = 0;
  double mean_edge_mm = 0;
  double smallest_angle_deg = 0;
  double sharpest_fold_deg = 0;  ///< largest angle between neighbouring triangles
};

/// Measures a body and refuses what must not ship: throws Error when it is not closed, inside out,
/// crosses itself or has an angle of 20 degrees or less.
BodyFacts inspect(const std::string& name, const Surface& body_mm);

/// A surface of these points and triangles.
Surface surface_of(const std::vector<Vec3>& vertices,
                   const std::vector<std::array<std::int32_t, 3>>& triangles);

/// Positions rounded to the 1e-4 mm that a file holds.
Surface rounded(Surface body_mm);

/// Wavefront OBJ text: `v` lines with 4 decimals, `f` lines from 1.
std::string obj_text(const std::string& comment, const Surface& body_mm);

}  // namespace palpate::bodies
