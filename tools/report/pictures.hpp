#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/recorded_signals.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {

/// One recording to be drawn, with the contact model that was fitted to it, if one was.
struct RecordingPicture {
  RecordedSignal signal;
  std::string model;            ///< empty: none
  std::vector<float> fitted_N;  ///< of each reading of the trace without its bias; NaN: nothing
  double young_Pa = 0, young_deviation_Pa = 0;  ///< NaN where there is none
  std::optional<Vec3> position_m;
};

/// What the page draws of recordings, refused ones first, then from poor to good. Of more than
/// 1,000 as many of each grade in that order, equally spaced, as there is room for.
Json pictures_json(const std::vector<RecordingPicture>& pictures);

}  // namespace palpate::tools
