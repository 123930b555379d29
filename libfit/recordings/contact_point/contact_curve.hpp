#pragma once

#include "libfit/recordings/contact_point/contact_point.hpp"

namespace palpate::recordings {

/// Contact point of a curve of which nothing is known but that it is smooth and begins rising:
///   push = bias before contact, and from there on the integral of a slope that wanders
/// (a Wiener process of unknown intensity: the cubic smoothing spline). Mean and deviation of its
/// posterior, flat in the contact point, the bias, the first slope (which is not negative) and the
/// logarithm of the intensity; the noise is the curve's own, and where free means go together their
/// number is less. Costs one pass over the means for each of 24 intensities. amplitude is 0.
/// Preconditions: at least 5 means, and a push that rises.
/// Source: Wahba (1978), doi:10.1111/j.2517-6161.1978.tb01050.x (splines as posterior means);
/// Durbin and Koopman (2012), Time Series Analysis by State Space Methods, 4.3 (the filter).
ContactEstimate contact_of_smooth_curve(const PressCurve& curve);

}  // namespace palpate::recordings
