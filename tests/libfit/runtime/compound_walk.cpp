// Random ways of rigid tools of two to six balls over an asset, whose contacts feel each other as
// much as they may: each presses, slides, tips over, rolls or lifts. Fails where what a tool stores
// and the tank rise without work, or a walk gives work as somebody beside it measures it: force
// over motion and torque over turns. compound_walk ASSET TICKS SEED
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/runtime/engine.hpp"
#include "libfit/runtime/tool/tool.hpp"
#include "tests/libfit/runtime/outside_work.hpp"
#include "tests/libfit/runtime/random_share.hpp"

namespace {

using namespace palpate::runtime;
using palpate::test::Random;

// A tool's frame, turned from the body's axes by a vector.
Frame frame_at(const Vec3d& place, const Vec3d& turn) {
  Pose pose;
  put(place, pose.position_m);
  const double angle = std::sqrt(dot(turn, turn));
  if (angle > 0) {
    pose.orientation[0] = std::cos(angle / 2);
    put(turn * (std::sin(angle / 2) / angle), pose.orientation + 1);
  }
  Frame out;
  make_frame(pose, out);
  return out;
}

// The turn from one frame to the next as a vector: half of what is skew in R now R before^T.
Vec3d turn_between(const Frame& before, const Frame& now) {
  Vec3d out{0, 0, 0};
  for (int k = 0; k < 3; ++k) {  // the axes, columns of the rows
    const Vec3d axis{k == 0 ? 1.0 : 0, k == 1 ? 1.0 : 0, k == 2 ? 1.0 : 0};
    out = out + cross(before.turn(axis), now.turn(axis)) * 0.5;
  }
  return out;
}

Vec3d direction(Random& random) {
  return {2 * random.share() - 1, 2 * random.share() - 1, 2 * random.share() - 1};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const palpate::AssetFile file = palpate::read_asset_file(argv[1]);
  AssetView asset = file.asset();
  const double radius_m = asset.probe_radius_m > 0 ? asset.probe_radius_m : asset.max_fitted_m;
  asset.probe_radius_m = radius_m;
  CouplingView feel;
  feel.length_m = 0.5 * radius_m;
  for (int k = 0; k < kCouplingScales; ++k) feel.give_m_N[k] = 1.0 / (1 << k);
  const double excess = coupling_excess(asset, feel);
  for (double& a : feel.give_m_N) a /= excess;
  asset.coupling = &feel;
  std::vector<int> covered;
  for (int v = 0; v < asset.vertices; ++v)
    if (asset.covered[v] == kMeasured) covered.push_back(v);
  Random random{2 * std::strtoull(argv[3], nullptr, 10) + 1};
  const double depth_m = asset.max_fitted_m;
  long ticks = 0, walks = 0, several = 0, slipping = 0;
  double refused_J = 0, worst[palpate::test::kLevels] = {};
  static CompoundTool tool;
  static CompoundOutput out;
  // The same walk in finer ticks, every 20th: `level` of kFiner.
  int level = 0;
  Random again = random;
  while (ticks < std::atol(argv[2])) {
    const bool is_measured = level == 0 && walks % 20 == 0;
    if (level == 0) {
      ++walks;
      again = random;
    } else {
      random = again;
    }
    tool = CompoundTool();
    tool.shape.balls = 2 + static_cast<int>(5 * random.share());
    tool.shape.radius_m = radius_m;
    for (int i = 0; i < tool.shape.balls; ++i)
      put(Vec3d{radius_m * i, 0, 0} + direction(random) * (0.2 * radius_m), tool.shape.centre_m[i]);
    const int v = covered[static_cast<std::size_t>(random.share() * double(covered.size()))];
    const Vec3d u = asset.normal_at(v),
                home =
                    asset.vertex_at(v) + make_vec3<double>(asset.origin_m) - u * (radius_m + 0.002);
    Vec3d at = home, turn = direction(random) * 0.3;
    double lost_J = 0, peak_J = 0;
    bool is_passive = true;
    palpate::test::OutsideWork by_force, by_torque;
    Frame before = frame_at(at, turn);
    double work_J = 0, in_J = 0;
    const auto tick = [&]() {
      const Frame now = frame_at(at, turn);
      if (touch_compound(asset, tool, now, out) != Status::ok) return false;
      const double until_J = by_force.work_J + by_torque.work_J;
      by_force.add(make_vec3<double>(out.force_on_tool_N), now.origin - before.origin);
      by_torque.add(make_vec3<double>(out.torque_on_tool_Nm), turn_between(before, now));
      before = now;
      work_J = by_force.work_J + by_torque.work_J;
      in_J += std::max(work_J - until_J, 0.0);
      ticks += level == 0;
      several += level == 0 && out.touching > 1;
      for (int i = 0; i < tool.shape.balls && level == 0; ++i)
        slipping += out.ball[i].state == ContactState::slip;
      peak_J = out.stored_J > peak_J ? out.stored_J : peak_J;
      const Ledger& ledger = tool.joint.ledger;
      const double lost = ledger.dissipated_J - ledger.tank_J,
                   rounding_J = 1e-11 * peak_J + 1e-14 * ledger.dissipated_J;
      const bool is_good = lost >= lost_J - rounding_J && out.stored_J >= 0;
      lost_J = lost;
      return is_good;
    };
    is_passive = tick();
    for (int leg = 0; leg < 7 && is_passive; ++leg) {
      const Vec3d from = at, from_turn = turn;
      Vec3d to = home - u * 0.01, to_turn = turn + direction(random) * 0.2;
      if (leg < 6)
        to = home + u * (0.002 + depth_m * (0.9 * random.share())) +
             tangential(direction(random) * (2 * depth_m), u);
      const Vec3d way = to - from;
      const double step_m = 1e-5 * (1 + 9 * random.share());
      const long count =
          palpate::test::kFiner[level] * (1 + static_cast<long>(std::sqrt(dot(way, way)) / step_m));
      for (long k = 1; k <= count && is_passive; ++k) {
        at = from + way * (double(k) / double(count));
        turn = from_turn + (to_turn - from_turn) * (double(k) / double(count));
        is_passive = tick();
      }
    }
    if (level == 0) refused_J += tool.joint.ledger.refused_J;
    if (in_J > 0) worst[level] = std::min(worst[level], work_J / in_J);
    level = is_measured || (level > 0 && level + 1 < palpate::test::kLevels) ? level + 1 : 0;
    if (is_passive) continue;
    std::printf("walk %ld of seed %s is not passive or was refused\n", walks, argv[3]);
    return 1;
  }
  std::printf("%ld ticks in %ld walks, %ld of two balls and more, %ld balls slipping\n", ticks,
              walks, several, slipping);
  std::printf(
      "refused %.6g J; least share of what was put in that a walk took, from outside, in\n"
      "1, 4, 16 and 64 times as many ticks: %.3g %.3g %.3g %.3g\n",
      refused_J, worst[0], worst[1], worst[2], worst[3]);
  const bool gives = worst[palpate::test::kLevels - 1] < -palpate::test::kMostGiven;
  return several > ticks / 8 && !gives ? 0 : 1;
}
