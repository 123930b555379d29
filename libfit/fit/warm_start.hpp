#pragma once

#include <string>
#include <vector>

#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// What each point's curves depend on besides bases and family: its place, its rows (experiments
/// counted from the point's first), the options that a point's own fit reads, radius and friction
/// of the probe, what other points say of rings, what is unknown of its recordings, and the body's
/// force error where its own rows state none. 16 hex digits a point; equal means that the curves
/// need no refit. body, bases: of these samples.
std::vector<std::string> fingerprints(const Samples& samples, const BodyData& body,
                                      const BodyBases& bases, const FitOptions& options);

/// Options of a warm start: bases and family as the earlier fit had them. Throws Error where its
/// curves are of several degrees.
FitOptions as_before(FitOptions options);

/// The point of the earlier fit with each fingerprint, or -1; all -1 without a cache.
std::vector<Eigen::Index> earlier_points(const FitOptions& options,
                                         const std::vector<std::string>& fingerprint);

/// An earlier point's result, not scored yet. experiments: of the point.
PointResult kept_point(const FitOptions& options, Eigen::Index earlier, std::size_t experiments);

}  // namespace palpate::fit
