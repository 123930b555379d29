#include "libfit/validation/follow.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace palpate::validation {
namespace {

constexpr double kTick_m = 20e-6;       // 20 mm/s at 1 kHz
constexpr double kApproachRatio = 0.1;  // of the depth, from outside, before the first row
constexpr std::size_t kTimedTicks = 200000;

class Follower {
 public:
  explicit Follower(const runtime::AssetView& asset) : asset_(asset) {}

  Followed follow(const Vec3& point, const Vec3& normal, const Points& deflections,
                  double approach_m) {
    Followed followed{Points(deflections.rows(), 3), {}};
    runtime::Contact contact;
    Vec3 deflection = -approach_m * normal;
    tick(contact, point + deflection);
    for (Eigen::Index row = 0; row < deflections.rows(); ++row) {
      const Vec3 from = deflection, way = Vec3(deflections.row(row)) - from;
      const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / kTick_m)));
      runtime::Output out;
      for (int k = 1; k <= steps; ++k)
        out = tick(contact, point + from + way * (double(k) / steps));
      deflection = deflections.row(row);
      for (int k = 0; k < 3; ++k) followed.force(row, k) = -out.force_on_tool_N[k];
      followed.is_sliding.push_back(out.state == runtime::ContactState::slip);
    }
    return followed;
  }

  std::size_t ticks() const { return ticks_; }

 private:
  runtime::Output tick(runtime::Contact& contact, const Vec3& tip) {
    runtime::Output out;
    runtime::touch(asset_, contact, tip.data(), out);  // a status but ok comes with zero force
    ++ticks_;
    return out;
  }

  const runtime::AssetView& asset_;
  std::size_t ticks_ = 0;
};

Followed follow_one(Follower& follower, const HeldOut& held_out, std::size_t path, double depth_m) {
  const auto i = static_cast<Eigen::Index>(path);
  return follower.follow(held_out.points.position.row(i), held_out.points.normal.row(i),
                         held_out.paths[path].deflections, kApproachRatio * depth_m);
}

}  // namespace

std::vector<Followed> follow_paths(const runtime::AssetView& asset, const HeldOut& held_out,
                                   double depth_m) {
  Follower follower(asset);
  std::vector<Followed> followed;
  for (std::size_t path = 0; path < held_out.paths.size(); ++path)
    followed.push_back(follow_one(follower, held_out, path, depth_m));
  return followed;
}

double time_ticks_ns(const runtime::AssetView& asset, const HeldOut& held_out, double depth_m) {
  Follower follower(asset);
  const auto started = std::chrono::steady_clock::now();
  while (follower.ticks() < kTimedTicks)
    for (std::size_t path = 0; path < held_out.paths.size(); ++path)
      follow_one(follower, held_out, path, depth_m);
  const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - started;
  return spent.count() / static_cast<double>(follower.ticks());
}

}  // namespace palpate::validation
