#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "libfit/core/curves.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate {

struct FitStatusName {
  FitStatus status;
  std::string_view name;
};
inline constexpr std::array<FitStatusName, 4> kFitStatusNames{{
    {FitStatus::good, "good"},
    {FitStatus::underdetermined, "underdetermined"},
    {FitStatus::poor, "poor"},
    {FitStatus::failed, "failed"},
}};

/// Fitted curves of a curves.h5 (docs/formats.md). Throws Error on missing or malformed columns,
/// curves that fall, do not start at 0 or are not exact in float32. Residuals may be NaN.
FittedCurves read_curves(const std::filesystem::path& path);

/// Stores them, whole or not at all. Refuses what read_curves would refuse.
void write_curves(const std::filesystem::path& path, const FittedCurves& curves,
                  const Attributes& attributes = {});

}  // namespace palpate
