#include "libfit/shape/contact_states.hpp"

#include "libfit/experiments/follow.hpp"

namespace palpate {

std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples,
                                                            double depth_m) {
  std::vector<std::optional<runtime::Contact>> states(samples.point.size());
  bool has_failed = false;
  follow(asset, samples, depth_m, {}, [&](Eigen::Index at, const runtime::Tool& tool) {
    const auto row = static_cast<std::size_t>(at);
    if (row == 0 || samples.experiment[row] != samples.experiment[row - 1]) has_failed = false;
    has_failed = has_failed || samples.status[row] != RowStatus::good;
    if (!has_failed && tool.contact[0].triangle >= 0) states[row] = tool.contact[0];
  });
  return states;
}

}  // namespace palpate
