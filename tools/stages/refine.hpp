#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Samples, with how the surface moved where that is known.
Samples read_known(const std::filesystem::path& samples);

/// Curves on every fine node of the body's surface, with the probe of the curves; coverage is said
/// on stderr. samples: those of the curves, which tell how the surface moves and, of a scene with
/// pairs or a [tool], how contacts feel each other. scene: null of points that were measured.
Model refine_body(const FittedCurves& curves, const Body& body, const Samples& samples,
                  const Scene* scene);

/// The largest depth of rows [m]; 0 where none is inward.
double deepest_m(const Samples& samples);

/// The attribute of model.h5 that says how many test points have no curves of their own, in words.
inline constexpr const char* kGuessedAttribute = "points_without_curves_of_their_own";

/// Attributes of a model.h5 of these curves: what it was made from, and kGuessedAttribute where
/// some points are underdetermined or failed.
Attributes model_attributes(const FittedCurves& curves, const std::string& made_from);

}  // namespace palpate::tools
