#pragma once

#include <filesystem>
#include <optional>

#include "libfit/core/fit_cache.hpp"

namespace palpate {

/// The side file of a curves.h5, `curves.h5.warm`: may be deleted at any time.
std::filesystem::path fit_cache_path(const std::filesystem::path& curves_path);

/// What the fit of these curves left for a warm start. Nothing where the side file is missing,
/// damaged, or not of the curves.h5 as it is now: then a warm start takes longer.
std::optional<FitCache> read_fit_cache(const std::filesystem::path& curves_path,
                                       const FittedCurves& curves);

/// Stores it beside curves.h5, which is there already, whole or not at all.
void write_fit_cache(const std::filesystem::path& curves_path, const FitCache& cache);

}  // namespace palpate
