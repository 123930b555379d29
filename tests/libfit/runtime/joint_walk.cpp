// Random ways of one to four tools over an asset, which feel each other as much as they may: each
// presses, slides, stands or lifts as it likes, 10 um to 0.2 mm a tick. Fails where what all store
// and the tank rise without work, where a walk gives work as somebody beside it measures it, or a
// force changes by more than two ordinary ticks. joint_walk ASSET TICKS SEED
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/runtime/engine.hpp"
#include "libfit/runtime/series/tick.hpp"
#include "tests/libfit/runtime/outside_work.hpp"
#include "tests/libfit/runtime/random_share.hpp"

namespace {

using namespace palpate::runtime;
using palpate::test::Random;

struct Sums {
  long ticks = 0, walks = 0, touching = 0, together = 0, slipping = 0, in_debt = 0, unfinished = 0,
       crowded = 0;
  double refused_J = 0, jump = 0, work_J = 0, in_J = 0, worst[palpate::test::kLevels] = {};
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const palpate::AssetFile file = palpate::read_asset_file(argv[1]);
  AssetView asset = file.asset();
  CouplingView feel;
  feel.length_m = 0.5 * (asset.probe_radius_m > 0 ? asset.probe_radius_m : asset.max_fitted_m);
  for (int k = 0; k < kCouplingScales; ++k) {
    feel.give_m_N[k] = 1.0 / (1 << k);
    feel.across_m_N[k] = 0.2 / (1 << k);
  }
  const double excess = coupling_excess(asset, feel);
  for (int k = 0; k < kCouplingScales; ++k) {
    feel.give_m_N[k] /= excess;
    feel.across_m_N[k] /= excess;
  }
  asset.coupling = &feel;
  double stiffest_N_m = 0;
  std::vector<int> covered;
  for (int v = 0; v < asset.vertices; ++v) {
    if (asset.covered[v] != kMeasured) continue;
    covered.push_back(v);
    const SplineView& spline = asset.curves.view[kNormal];
    stiffest_N_m =
        std::max(stiffest_N_m, curve_slope(spline, asset.node(v) + asset.control_offset[kNormal],
                                           spline.knots[spline.pieces]));
  }
  Random random{2 * std::strtoull(argv[3], nullptr, 10) + 1};
  const double depth_m = asset.max_fitted_m;
  Sums sums;
  // The same walk in finer ticks, every 20th: `level` of kFiner.
  int level = 0;
  Random again = random;
  while (sums.ticks < std::atol(argv[2])) {
    const bool is_measured = level == 0 && sums.walks % 20 == 0;
    if (level == 0) {
      ++sums.walks;
      again = random;
    } else {
      random = again;
    }
    const int n = 1 + static_cast<int>(4 * random.share());
    Contact contact[4];
    JointTool tool[4];
    Joint joint;
    Vec3d at[4], home[4], inward[4], force[4];
    const int middle = covered[static_cast<std::size_t>(random.share() * double(covered.size()))];
    for (int i = 0; i < n; ++i) {
      int v = middle;  // near each other in half of the walks
      for (int k = 0; k < 40; ++k) {
        v = covered[static_cast<std::size_t>(random.share() * double(covered.size()))];
        const Vec3d way = asset.vertex_at(v) - asset.vertex_at(middle);
        if (sums.walks % 2 == 0 || dot(way, way) < 25 * depth_m * depth_m) break;
      }
      inward[i] = asset.normal_at(v);
      home[i] = asset.vertex_at(v) + make_vec3<double>(asset.origin_m);
      at[i] = home[i] - inward[i] * 0.002;
      force[i] = {0, 0, 0};
    }
    double lost_J = 0, peak_J = 0, work_J = 0, in_J = 0;
    const auto tick = [&](const Vec3d* to) {
      double moved = 0;
      for (int i = 0; i < n; ++i) {
        const Vec3d step = to[i] - at[i];
        moved += std::sqrt(dot(step, step));
        tool[i].contact = &contact[i];
        put(to[i], tool[i].place_m);
      }
      touch_together(asset, joint, tool, n);
      sums.ticks += level == 0;
      double stored_J = 0, work = 0;
      int touching = 0;
      for (int i = 0; i < n; ++i) {
        const Output& out = tool[i].out;
        if (tool[i].status != Status::ok) return false;
        const Vec3d now = make_vec3<double>(out.force_on_tool_N) * -1.0, change = now - force[i];
        work += 0.5 * dot(now + force[i], to[i] - at[i]);
        if (moved > 0 && level == 0)
          sums.jump = std::max(sums.jump, std::sqrt(dot(change, change)) / (stiffest_N_m * moved));
        force[i] = now;
        at[i] = to[i];
        stored_J += out.stored_J;
        touching += out.state != ContactState::air;
        sums.slipping += out.state == ContactState::slip;
        sums.crowded += (out.flags & kFlagCrowded) != 0;
      }
      sums.touching += touching > 0;
      sums.together += touching > 1;
      sums.unfinished += (tool[0].out.flags & kFlagUnfinished) != 0;
      sums.in_debt += joint.ledger.debt_J > 0;
      work_J += work;
      in_J += std::max(work, 0.0);
      peak_J = std::max(peak_J, stored_J);
      const double lost = joint.ledger.dissipated_J - joint.ledger.tank_J;
      const bool is_passive = lost >= lost_J - 1e-11 * peak_J && stored_J >= 0;
      lost_J = lost;
      return is_passive;
    };
    bool is_passive = tick(at);
    for (int leg = 0; leg < 7 && is_passive; ++leg) {
      Vec3d from[4], to[4];
      double longest_m = 0;
      for (int i = 0; i < n; ++i) {
        from[i] = to[i] = at[i];
        const double choice = random.share();
        const Vec3d aside = tangential(
            Vec3d{random.share() - 0.5, random.share() - 0.5, random.share() - 0.5}, inward[i]);
        if (leg == 6 || choice < 0.15)
          to[i] = home[i] - inward[i] * (depth_m + 0.005);
        else if (choice < 0.85)
          to[i] = home[i] + aside * (2 * depth_m) +
                  inward[i] * (depth_m * (0.2 + 0.75 * random.share()));
        const Vec3d way = to[i] - from[i];
        longest_m = std::max(longest_m, std::sqrt(dot(way, way)));
      }
      const double step_m = 1e-5 * (1 + 19 * random.share() * random.share());
      const long ticks =
          palpate::test::kFiner[level] * std::max(1L, static_cast<long>(longest_m / step_m));
      for (long k = 1; k <= ticks && is_passive; ++k) {
        Vec3d here[4];
        for (int i = 0; i < n; ++i)
          here[i] = from[i] + (to[i] - from[i]) * (double(k) / double(ticks));
        is_passive = tick(here);
      }
    }
    if (in_J > 0) sums.worst[level] = std::min(sums.worst[level], work_J / in_J);
    if (level == 0) {
      sums.work_J += work_J;
      sums.in_J += in_J;
      sums.refused_J += joint.ledger.refused_J;
    }
    level = is_measured || (level > 0 && level + 1 < palpate::test::kLevels) ? level + 1 : 0;
    if (is_passive) continue;
    std::printf("walk %ld of seed %s is not passive or was refused\n", sums.walks, argv[3]);
    return 1;
  }
  std::printf(
      "%ld ticks in %ld walks, %ld in contact, %ld of two and more, %ld slipping, %ld tools "
      "crowded\n",
      sums.ticks, sums.walks, sums.touching, sums.together, sums.slipping, sums.crowded);
  std::printf(
      "put in %.6g J, lost %.6g J; least share of it that a walk took, from outside, in\n"
      "1, 4, 16 and 64 times as many ticks: %.3g %.3g %.3g %.3g\n",
      sums.in_J, sums.work_J, sums.worst[0], sums.worst[1], sums.worst[2], sums.worst[3]);
  std::printf("refused %.6g J, %ld ticks in debt, %ld unfinished\n", sums.refused_J, sums.in_debt,
              sums.unfinished);
  std::printf(
      "largest change of a force, over the stiffest curve times the ways of all tools: %.3f\n",
      sums.jump);
  const bool gives = sums.worst[palpate::test::kLevels - 1] < -palpate::test::kMostGiven;
  return sums.together > sums.ticks / 8 && sums.jump < 2 && !gives ? 0 : 1;
}
