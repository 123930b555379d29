#pragma once

#include "libfit/fit/point/fit_point.hpp"

// What is unknown of recordings besides the curves: docs/method-recordings.md, section 15.

namespace palpate::fit {

/// Sets PointExperiment::unknown as the options ask. The contact point of an experiment is as
/// uncertain as its recordings' (the mean of those pooled), or as the option says where they state
/// nothing. Throws Error when contact points are to be found and nothing says how uncertain any of
/// them is.
void add_nuisances(const Samples& samples, const FitOptions& options, BodyData& body);

/// Whether anything is unknown of any experiment.
bool has_nuisances(const BodyData& body);

/// A point's rows as they would have been recorded without its nuisance values.
PointData without_nuisances(PointData point, const std::vector<NuisanceValues>& nuisance);

/// Rows for curves.h5; none where nothing was unknown.
FittedRecordings collect_nuisances(const BodyData& body, const std::vector<PointResult>& results);

/// A point's nuisance values of an earlier fit, in the order of its experiments.
void restore_nuisances(const FittedRecordings& earlier, Eigen::Index point, std::size_t experiments,
                       PointResult& result);

}  // namespace palpate::fit
