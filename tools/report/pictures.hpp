#pragma once

#include <vector>

#include "libfit/core/recorded_signals.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {

/// What the page draws of recordings, refused ones first, then from poor to good. Of more than
/// 1,000 as many of each grade in that order, equally spaced, as there is room for.
Json pictures_json(const std::vector<RecordedSignal>& signals);

}  // namespace palpate::tools
