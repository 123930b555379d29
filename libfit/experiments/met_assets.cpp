#include "libfit/experiments/met_assets.hpp"

#include <cmath>

namespace palpate {

const runtime::AssetView* MetAssets::of(const Indenter& end) {
  const double own_m = asset_.probe_radius_m;
  if (!runtime::knows_radius(asset_) || !runtime::is_possible(end)) return nullptr;
  if (end.points == 0 && std::abs(end.round_end_m - own_m) <= runtime::kSameRadius * own_m)
    return nullptr;
  const std::uint64_t mark = runtime::mark_of(end);
  for (const Met& met : met_)
    if (met.mark == mark) return &met.view;
  Met& met = met_.emplace_back();
  met.mark = mark;
  met.memory.resize(runtime::indenter_bytes(asset_) / sizeof(std::uint64_t));
  met.view = runtime::with_indenter(asset_, end, met.memory.data());
  return &met.view;
}

void MetAssets::put_into(const std::vector<Indenter>& end, runtime::ToolShape& shape) {
  for (int i = 0; i < shape.balls && i < static_cast<int>(end.size()); ++i)
    shape.ball[i].asset = of(end[static_cast<std::size_t>(i)]);
}

}  // namespace palpate
