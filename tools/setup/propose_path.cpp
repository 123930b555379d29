#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/experiments/draw.hpp"
#include "tools/setup/propose.hpp"

namespace palpate::tools {
namespace {

// From rest to rest in least jerk (Flash and Hogan 1985, doi:10.1523/JNEUROSCI.05-07-01688.1985).
double eased(double share) { return share * share * share * (10 + share * (-15 + 6 * share)); }

}  // namespace

ProposedPath propose_path(const runtime::AssetView& asset) {
  constexpr double kRate_Hz = 1000;
  Body body;
  body.surface = palpate::surface_of(asset);
  Vec3 middle = Vec3::Zero();
  int measured = 0;
  for (int v = 0; v < asset.vertices; ++v) {
    body.is_reachable.push_back(asset.covered[v] == runtime::kMeasured);
    if (!body.is_reachable[v]) continue;
    middle += body.surface.vertices.row(v);
    ++measured;
  }
  middle /= measured;
  ProposedPath out;
  // Neither light nor at the end of what curves were fitted to; twice as far as deep slips.
  out.depth_m = 0.6 * asset.max_fitted_m;
  const HeldOut drawn =
      draw_sliding(body, {.depth_m = out.depth_m, .drag_distance_m = 2 * out.depth_m}, 64, 1);
  const Points& places = drawn.points.position;
  Eigen::Index best = 0;
  for (Eigen::Index i = 2; i < places.rows(); i += 2)  // between them are paths that wander
    if ((places.row(i) - middle.transpose()).norm() <
        (places.row(best) - middle.transpose()).norm())
      best = i;

  out.touched = places.row(best);
  const Vec3 inward = drawn.points.normal.row(best);
  const Points& rows = drawn.paths[best].deflections;  // four of the press, four of the drag
  const Vec3 pressed = out.depth_m * inward,
             there = pressed + (rows.row(7) - rows.row(3)).transpose();
  out.slide_m = (there - pressed).norm();
  const auto free_m = ray_distance_m(body.surface, triangle_boxes(body.surface), out.touched,
                                     -inward, 1e-6 * extent_m(body.surface.vertices).norm());
  const double above_m = std::min(asset.max_fitted_m, free_m ? *free_m / 2 : asset.max_fitted_m);
  std::vector<Vec3> tips{out.touched - above_m * inward};
  const auto go = [&](const Vec3& deflection, double time_s) {
    const Vec3 from = tips.back(), to = out.touched + deflection;
    const auto ticks = static_cast<int>(std::lround(time_s * kRate_Hz));
    for (int i = 1; i <= ticks; ++i)
      tips.push_back(from + eased(static_cast<double>(i) / ticks) * (to - from));
  };
  go(pressed, 0.6);
  go(pressed, 0.2);
  go(there, 1);
  go(there - (out.depth_m + above_m) * inward, 0.4);
  out.tip.position.resize(tips.size(), 3);
  const Eigen::Vector4d upright =
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), -inward).coeffs();
  out.tip.orientation = upright.transpose().replicate(out.tip.position.rows(), 1);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    out.tip.time_s.push_back(static_cast<double>(i) / kRate_Hz);
    out.tip.position.row(i) = tips[i];
  }
  return out;
}

}  // namespace palpate::tools
