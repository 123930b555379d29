#pragma once

#include <array>
#include <optional>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/refine/refine.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What `--free` and `--contact-deviation` say of measured recordings; see FitOptions.
struct NuisanceChoice {
  std::array<bool, 3> estimates{false, false, false};
  double contact_deviation_m = 0;
};
/// names: names with commas between. contact_deviation: a length with unit, or empty.
/// Throws Error on names and lengths that are none.
NuisanceChoice nuisance_choice(const std::string& names, const std::string& contact_deviation);

/// Strength that `--smoothing` asks for: "auto" (nothing), "none" (0) or a number of 0 to 1e12.
/// Throws Error on other texts.
std::optional<double> smoothing_choice(const std::string& text);

/// Triangles over the samples' points, which say who are neighbours: the body's own where its test
/// points are these, else made over its surface as `refine` does.
Triangles neighbour_triangles(const Samples& samples, const Body& body);

/// An earlier fit to go on from, and what it left; see FitOptions.
struct WarmStart {
  const FittedCurves* curves = nullptr;
  const FitCache* cache = nullptr;
};

/// What a fit is told: by the samples (friction of their probe, Poisson's ratio of their body; that
/// simulated ones are not smoothed by default), and by [fit]. The one place where stages fill
/// FitOptions. Throws Error on an unknown family.
FitOptions fit_options(const Samples& samples, const FitSection& section, int jobs);

/// Curves at the test points, with basis, residuals and worst points said on stderr, and how the
/// body softens where there are cycles. They carry the probe of the samples.
/// body: its surface says which points are neighbours, else their places do; may be null.
/// cache: filled for a later warm start, where wanted.
/// Throws Interrupted when the user stopped it: nothing half-fitted is kept.
FittedCurves fit_samples(const Samples& samples, const FitSection& section, int jobs,
                         const Body* body = nullptr, const WarmStart& warm = {},
                         const NuisanceChoice& nuisances = {}, FitCache* cache = nullptr);

/// Lists points without curves of their own (underdetermined, failed) on stderr, at most a
/// screenful. Returns how many there are: exit status 3 rather than 0. `poor` ones are fitted.
/// is_quick: too few rows are what was asked for, so underdetermined points count as fitted.
std::size_t list_bad_points(const FittedCurves& curves, bool is_quick = false);

/// Samples, with how the surface moved where that is known.
Samples read_known(const std::filesystem::path& samples);

/// Curves on every fine node of the body's surface, with the probe of the curves; coverage is said
/// on stderr. samples: those of the curves, which tell how the surface moves and, of a scene with
/// pairs or a [tool], how contacts feel each other. scene: null where it is not known.
Model refine_body(const FittedCurves& curves, const Body& body, const RefineOptions& options = {},
                  const Samples& samples = {}, const Scene* scene = nullptr);

/// RefineOptions::slope_share from text: auto or a number.
std::optional<double> slope_share_choice(const std::string& text);

/// RefineOptions::follows_shape from text: auto, yes or no.
std::optional<bool> follow_shape_choice(const std::string& text);

}  // namespace palpate::tools
