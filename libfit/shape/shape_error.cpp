#include "libfit/shape/shape.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/geometry.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/experiments/follow.hpp"

namespace palpate {
namespace {

struct Errors {
  std::vector<double> error_m, share;

  void add(double error, double depth_m) {
    error_m.push_back(error);
    share.push_back(error / depth_m);
  }
  ShapeErrorFigures figures() const {
    return {stated_quantile(error_m, 0.5), stated_quantile(error_m, 0.95),
            stated_quantile(error_m, 1),   stated_quantile(share, 0.5),
            stated_quantile(share, 0.95),  stated_quantile(share, 1)};
  }
};

}  // namespace

std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples,
                                                            double depth_m) {
  std::vector<std::optional<runtime::Contact>> states(samples.point.size());
  bool has_failed = false;
  follow(asset, samples, depth_m, {}, [&](Eigen::Index at, const runtime::Tool& tool) {
    if (at == 0 || samples.experiment[at] != samples.experiment[at - 1]) has_failed = false;
    has_failed = has_failed || samples.status[at] != RowStatus::good;
    if (!has_failed && tool.contact[0].triangle >= 0) states[at] = tool.contact[0];
  });
  return states;
}

ShapeError shape_error(const runtime::AssetView& asset, const Samples& samples,
                       const std::vector<std::optional<runtime::Contact>>& contacts,
                       bool is_shown) {
  Errors near, all;
  ShapeError out;
  for (std::size_t row = 0; row < contacts.size(); ++row) {
    runtime::DentState state;
    if (!contacts[row]) continue;
    if (!runtime::shape_state(asset, *contacts[row], 0, state)) continue;
    if (!is_shown) state.radius_m = 0;
    const runtime::Deformation deformation(asset, *contacts[row], state);
    const double depth_m = std::max(state.normal_m, 0.1 * asset.shape.depth_m);
    const double reach_m = 3 * runtime::shape_radius_m(asset.shape, state.normal_m);
    const float* moved = samples.surface.row(row).data();
    for (int v = 0; v < asset.vertices; ++v) {
      const runtime::Vec3d rest = asset.vertex_at(v);
      runtime::Vec3d u = deformation.at(v);
      deformation.push_out(rest, u);
      const runtime::Vec3d difference =
          u -
          runtime::Vec3d{double(moved[3 * v]), double(moved[3 * v + 1]), double(moved[3 * v + 2])};
      const double error_m = std::sqrt(runtime::dot(difference, difference));
      const runtime::Vec3d offset = rest - state.point;
      all.add(error_m, depth_m);
      if (runtime::dot(offset, offset) <= reach_m * reach_m) near.add(error_m, depth_m);
    }
    ++out.rows;
  }
  out.near = near.figures();
  out.all = all.figures();
  return out;
}

}  // namespace palpate
