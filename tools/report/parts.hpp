#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {

// Each adds to a report's object what the page shows of one file of a run (docs/formats/report.md,
// "Contents of a report"); what is to be known goes to `warnings`.

void add_body(Json& json, const Body& body);
void add_model(Json& json, const Model& model);
void add_curves(Json& json, const FittedCurves& fitted);
/// fitted: the curves of the samples' points, or null.
void add_samples(Json& json, const Samples& samples, const FittedCurves* fitted);
/// path: validation.csv of a run.
void add_held_out(Json& json, const std::filesystem::path& path);
/// path: placement.csv of a run.
void add_placement(Json& json, const std::filesystem::path& path);
/// After the statement, which the asset must carry, too.
void add_asset(Json& json, const std::filesystem::path& path);

}  // namespace palpate::tools
