#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/follow.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What all rivals are given: a run of a scene whose probe is a ball. They are tuned on `samples`,
/// which Palpate is fitted to; none sees `paths`.
struct RivalBody {
  Scene scene;
  Body body;
  Samples samples;                 ///< presses and drags at test points
  Samples paths;                   ///< held out, a path at each point
  AssetFile asset;                 ///< Palpate's; of rivals its surface alone
  std::filesystem::path packages;  ///< folder of node_modules, of a rival in Node; empty: none
  double depth_m = 0, radius_m = 0;
  double dragged_cpu_s = 0, pressed_cpu_s = 0;  ///< of simulating one test point
};

/// How often a body with inertia had come to rest before its force was read.
struct RestCount {
  int rows = 0, rested = 0;

  /// Whether it had at half of the rows at least: else its forces are not those of a body at rest.
  bool is_kept() const { return 2 * rested >= rows; }
  std::string words(const char* of, int ticks) const;
};

/// A method with its settings, ready to be touched.
struct Rival {
  std::string name, settings;
  double size = 0;  ///< nodes or points, where there are several sizes of the method
  std::size_t bytes = 0;
  double preparation_cpu_s = 0;
  double modulus = 1;           ///< factor on its forces, where it was fitted
  double step_m = kWalkTick_m;  ///< way of the tool in a tick
  int rest_ticks = 0;  ///< most that the tool stays before its force counts, of a body with inertia
  RestCount rest;      ///< at the presses that its modulus was fitted to
  bool is_force_at_rest = false;      ///< its force is the tool's only where all rests
  std::function<double()> own_cpu_s;  ///< CPU of its ticks so far, where another process has them
  std::function<void(const Vec3& inward)> start;   ///< a tool outside that presses along `inward`
  std::function<Vec3(const Vec3& point_m)> force;  ///< ON THE BODY [N], at the ball's lowest point
};

/// Ticks with the tool where it is until the force of ten is within 0.5 % of what it was before
/// them, for rest_ticks at most; counts the row, and as rested where it is within 5 %.
void come_to_rest(const Rival& rival, const std::function<Vec3()>& tick, RestCount& count);

/// A row of the table of rivals. prepare: one rival of each size; none where a package is missing.
struct RivalRow {
  std::string_view name, summary;
  std::vector<Rival> (*prepare)(const RivalBody& body);
};

std::vector<Rival> prepare_proxy(const RivalBody& body);
std::vector<Rival> prepare_proxy_on_curves(const RivalBody& body);
std::vector<Rival> prepare_separable(const RivalBody& body);
std::vector<Rival> prepare_green(const RivalBody& body);
std::vector<Rival> prepare_palpate(const RivalBody& body);
std::vector<Rival> prepare_corotational(const RivalBody& body);
std::vector<Rival> prepare_explicit(const RivalBody& body);
std::vector<Rival> prepare_bullet(const RivalBody& body);
std::vector<Rival> prepare_mujoco(const RivalBody& body);

/// A body that is solved for at every tick: `start()`, `force(centre_m)` and `bytes()`.
template <class Solved>
Rival solved_rival(const std::shared_ptr<Solved>& solved, double radius_m) {
  Rival rival;
  const auto inward = std::make_shared<Vec3>(Vec3::Zero());
  rival.bytes = solved->bytes();
  rival.start = [solved, inward](const Vec3& u) {
    solved->start();
    *inward = u;
  };
  rival.force = [solved, inward, radius_m](const Vec3& point) -> Vec3 {
    return solved->force(point - radius_m * *inward);
  };
  return rival;
}

/// Side force over normal force where a drag has come to its end, the median of all drags: friction
/// of the tool's interface, and of a sunken ball that ploughs.
double drag_ratio(const Samples& samples);
/// CPU so far, of this process or of its own.
double spent_s(const Rival& rival);
/// The same with its forces times a factor, as with a modulus times it: the one with which the
/// forces of up to eight presses at test points have the least sum of relative errors, as many as
/// begin within four seconds. What walking them takes is preparation.
Rival with_fitted_modulus(Rival rival, const RivalBody& body);
/// Of the triangles that a proxy walks on.
std::size_t surface_bytes(const runtime::AssetView& asset);

/// Samples at some of their points alone.
Samples at_points(const Samples& samples, const std::vector<Eigen::Index>& points);
/// CPU of simulating the rows of samples, by what one dragged and one pressed point took.
double simulation_cpu_s(const RivalBody& body, const Samples& samples);

}  // namespace palpate::tools
