#include "libfit/certify/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace palpate::certify {
namespace {

using runtime::ContactState;
using runtime::Vec3d;

constexpr double kAir_m = 2e-4;  // a slide begins and ends that far above the surface

class SeededSlide {
 public:
  SeededSlide(const runtime::AssetView& asset, const SlideOptions& options, Certificate& out)
      : asset_(asset), options_(options), out_(out) {}

  void go(const Vec3d& to) {
    const Vec3d from = x_, path = to - from;
    const double length = std::sqrt(dot(path, path));
    const int steps = has_begun_ ? static_cast<int>(length / options_.step_m) : 1;
    for (int i = 1; i <= steps; ++i)
      tick(has_begun_ ? from + path * (i * options_.step_m / length) : to);
  }

 private:
  void tick(const Vec3d& x) {
    double at[3];
    runtime::put(x + runtime::make_vec3<double>(asset_.origin_m), at);
    runtime::Output now;
    runtime::touch_ball(asset_, contact_, at, options_.radius_m, now, nullptr,
                        runtime::kCheckTick_s);
    if (has_begun_) compare(now);
    has_begun_ = true;
    before_ = now;
    x_ = x;
  }
  void compare(const runtime::Output& now) {
    const bool was = before_.state != ContactState::air, is = now.state != ContactState::air;
    if (!was && !is) return;
    ++out_.ticks;
    const Vec3d f = runtime::make_vec3<double>(now.force_on_tool_N),
                step = f - runtime::make_vec3<double>(before_.force_on_tool_N);
    // A pull below 1 mN is none: a fortieth of what a hand notices. Dashpots of a breast leave 0.2.
    if (is && (dot(f, runtime::make_vec3<double>(now.normal)) > 1e-3 || now.stored_J < 0))
      ++out_.pulling_ticks;
    out_.held_ticks += (now.flags & PALPATE_FLAG_HELD_BACK) != 0;
    out_.refused_J += now.refused_J - before_.refused_J;
    out_.work_J +=
        std::max(now.stored_J + now.dissipated_J - before_.stored_J - before_.dissipated_J, 0.0);
    const double jump_N = std::sqrt(dot(step, step));
    const double edge_N = out_.jumps.edge_N;
    double& largest = jump_of(now, was, is);
    largest = std::max(largest, jump_N);
    if (out_.jumps.edge_N > edge_N) std::copy_n(now.contact_m, 3, out_.edge_jump_at_m);
    out_.stiffness_N_m = std::max(out_.stiffness_N_m, jump_N / options_.step_m);
    out_.force_N = std::max(out_.force_N, std::sqrt(dot(f, f)));
  }
  double& jump_of(const runtime::Output& now, bool was, bool is) {
    ForceJumps& jumps = out_.jumps;
    if (!was) return jumps.touch_N;
    if (!is) return jumps.release_N;
    return now.triangle != before_.triangle ? jumps.edge_N : jumps.inside_N;
  }

  const runtime::AssetView& asset_;
  const SlideOptions& options_;
  Certificate& out_;
  runtime::Contact contact_;
  runtime::Output before_;
  Vec3d x_{0, 0, 0};
  bool has_begun_ = false;
};

std::vector<int> measured_triangles(const runtime::AssetView& asset) {
  std::vector<int> out;
  for (int t = 0; t < asset.triangles; ++t) {
    int measured = 0;
    for (int k = 0; k < 3; ++k) measured += asset.covered[asset.corner(t, k)] == runtime::kMeasured;
    if (asset.is_solid(t) && measured == 3) out.push_back(t);
  }
  return out;
}

}  // namespace

Certificate certify(const runtime::AssetView& asset, const SlideOptions& options) {
  Certificate out;
  const std::vector<int> triangles = measured_triangles(asset);
  if (triangles.empty()) return out;
  std::mt19937_64 random(options.seed);
  const auto unit = [&] { return double(random() >> 11) * 0x1p-53; };  // the same everywhere
  for (int i = 0; i < options.slides; ++i) {
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
    SeededSlide slide(asset, options, out);
    slide.go(at(-kAir_m, 0, 0));
    slide.go(at(1.02 * depth_m * unit(), 0, 0));
    double a = 0, b = 0;
    for (int leg = 0; leg < 6; ++leg) {
      a = depth_m * (2 * unit() - 1);
      b = depth_m * (2 * unit() - 1);
      slide.go(at(1.02 * depth_m * unit(), a, b));
    }
    slide.go(at(-kAir_m, a, b));
  }
  return out;
}

double least_damping_Ns_m(double stiffness_N_m, double rate_Hz) {
  return 0.5 * stiffness_N_m / rate_Hz;  // (M23)
}

DeviceVerdict judge(const Device& device, double stiffness_N_m, double force_N) {
  DeviceVerdict out{device};
  out.force_fits = device.max_force_N == 0 || force_N <= device.max_force_N;
  out.stiffness_fits = device.max_stiffness_N_m == 0 || stiffness_N_m <= device.max_stiffness_N_m;
  out.resolution_fits = device.friction_N == 0 || device.resolution_m == 0 ||
                        0.5 * stiffness_N_m * device.resolution_m <= device.friction_N;  // (M24)
  return out;
}

}  // namespace palpate::certify
