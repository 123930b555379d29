#include "libfit/certify/continuity.hpp"

#include <algorithm>
#include <random>

namespace palpate::certify {
namespace {

using runtime::ContactState;
using runtime::Vec3d;

constexpr double kAir_m = 2e-4;   // a walk begins and ends that far above the surface
constexpr int kLegs = 6;          // of a walk in contact
constexpr double kLegDepths = 1;  // length of a leg, in depths of the triangle

class Walk {
 public:
  Walk(const runtime::AssetView& asset, const ContinuityOptions& options, Continuity& out)
      : asset_(asset), options_(options), out_(out) {}

  void go(const Vec3d& to) {
    const Vec3d from = x_, way = to - from;
    const double length = std::sqrt(dot(way, way));
    const int steps = has_begun_ ? static_cast<int>(length / options_.step_m) : 1;
    for (int i = 1; i <= steps; ++i)
      tick(has_begun_ ? from + way * (i * options_.step_m / length) : to);
  }

 private:
  void tick(const Vec3d& x) {
    const double at[3] = {x.x + asset_.origin_m[0], x.y + asset_.origin_m[1],
                          x.z + asset_.origin_m[2]};
    runtime::Output now;
    runtime::touch_ball(asset_, contact_, at, options_.radius_m, now, nullptr,
                        runtime::kCheckTick_s);
    const bool is_aside = now.state != ContactState::air;
    const Vec3d seen = is_aside ? x - runtime::make_vec3<double>(contact_.series.aside_m) : x;
    if (has_begun_) compare(now, seen - seen_);
    has_begun_ = true;
    before_ = now;
    x_ = x;
    seen_ = seen;
  }
  void compare(const runtime::Output& now, const Vec3d& went) {
    const bool was = before_.state != ContactState::air, is = now.state != ContactState::air;
    if (!was && !is) return;
    ++out_.ticks;
    if (is) out_.seen_m = std::max(out_.seen_m, std::sqrt(dot(went, went)));
    const Vec3d f = runtime::make_vec3<double>(now.force_on_tool_N),
                step = f - runtime::make_vec3<double>(before_.force_on_tool_N);
    const double jump_N = std::sqrt(dot(step, step));
    double& place = !was                                                          ? out_.touch_N
                    : !is                                                         ? out_.release_N
                    : ((now.flags | before_.flags) & runtime::kFlagHeldBack) != 0 ? out_.held_N
                    : ((now.flags ^ before_.flags) & runtime::kFlagExtrapolated) != 0
                        ? out_.range_end_N
                    : now.triangle != before_.triangle               ? out_.edge_N
                    : piece(now.normal_m) != piece(before_.normal_m) ? out_.knot_N
                                                                     : out_.inside_N;
    place = std::max(place, jump_N);
    out_.stiffness_N_m = std::max(out_.stiffness_N_m, jump_N / options_.step_m);
    out_.force_N = std::max(out_.force_N, std::sqrt(dot(f, f)));
  }
  int piece(double depth_m) const {
    return runtime::find_piece(asset_.curves.view[runtime::kNormal], depth_m);
  }

  const runtime::AssetView& asset_;
  const ContinuityOptions& options_;
  Continuity& out_;
  runtime::Contact contact_;
  runtime::Output before_;
  Vec3d x_{0, 0, 0}, seen_{0, 0, 0};
  bool has_begun_ = false;
};

}  // namespace

Continuity measure_continuity(const runtime::AssetView& asset, const std::vector<int>& triangles,
                              const ContinuityOptions& options) {
  Continuity out;
  if (triangles.empty()) return out;
  std::mt19937_64 random(options.seed);
  const auto unit = [&] { return double(random() >> 11) * 0x1p-53; };  // the same everywhere
  for (int i = 0; i < options.walks; ++i) {
    const int t = triangles[static_cast<std::size_t>(unit() * double(triangles.size()))];
    const double depth_m = std::min(asset.max_fitted_m, double(asset.max_depth_m[t]));
    double p = unit(), q = unit();
    if (p + q > 1) {
      p = 1 - p;
      q = 1 - q;
    }
    const double n[3] = {1 - p - q, p, q};
    Vec3d c{0, 0, 0};
    for (int k = 0; k < 3; ++k) c = c + asset.vertex_at(asset.corner(t, k)) * n[k];
    const Vec3d u = runtime::blended_normal(asset, t, n);
    const Vec3d side = normalized(cross(u, std::fabs(u.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                across = cross(u, side);
    const auto at = [&](double depth, double a, double b) {
      return c + u * (depth - options.radius_m) + side * a + across * b;
    };
    Walk walk(asset, options, out);
    walk.go(at(-kAir_m, 0, 0));
    walk.go(at(1.02 * depth_m * unit(), 0, 0));
    double a = 0, b = 0;
    for (int leg = 0; leg < kLegs; ++leg) {
      a = kLegDepths * depth_m * (2 * unit() - 1);
      b = kLegDepths * depth_m * (2 * unit() - 1);
      walk.go(at(1.02 * depth_m * unit(), a, b));
    }
    walk.go(at(-kAir_m, a, b));
  }
  return out;
}

}  // namespace palpate::certify
