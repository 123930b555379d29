#pragma once

#include <optional>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// The engine's contact at each row of the samples, every experiment replayed from outside at 20 um
/// a tick; a drag is first pressed to its depth. Empty where a row is not good, nothing touches, or
/// an earlier row of its experiment was not good. depth_m: the way in begins a tenth of it outside.
std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples, double depth_m);

}  // namespace palpate
