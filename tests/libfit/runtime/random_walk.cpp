// Random ways of a tip over an asset: press, six legs at 20 um to 0.4 mm a tick, lift. Says what
// was lost, what slips would have created, and the largest change of the force in a tick. Fails
// where stored energy and tank rise without work. random_walk ASSET TICKS SEED
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/runtime/engine.hpp"
#include "tests/libfit/runtime/random_share.hpp"

namespace {

using namespace palpate::runtime;
using palpate::test::Random;

struct Sums {
  long ticks = 0, walks = 0, in_contact = 0, slipping = 0, in_debt = 0, above = 0;
  double work_J = 0, least_J = 0, refused_J = 0, jump_N = 0;
};

class Walk {
 public:
  Walk(const AssetView& asset, const Vec3d& start, Sums& sums)
      : asset_(asset), sums_(sums), x_(start) {
    tick(start);
    ++sums.walks;
  }
  bool go(const Vec3d& to, double step_m) {
    const Vec3d from = x_, way = to - from;
    const long ticks = std::max(1L, static_cast<long>(std::sqrt(dot(way, way)) / step_m));
    for (long i = 1; i <= ticks; ++i)
      if (!tick(from + way * (double(i) / double(ticks)))) return false;
    return true;
  }
  void end() {
    sums_.work_J += out_.stored_J + out_.dissipated_J;
    sums_.refused_J += out_.refused_J;
  }

 private:
  bool tick(const Vec3d& x) {
    double at[3];
    put(x_ = x, at);
    if (touch(asset_, contact_, at, out_) != Status::ok) return false;
    const Vec3d force = make_vec3<double>(out_.force_on_tool_N), change = force - force_;
    const double jump = std::sqrt(dot(change, change));
    force_ = force;
    ++sums_.ticks;
    sums_.in_contact += out_.state != ContactState::air;
    sums_.slipping += out_.state == ContactState::slip;
    sums_.in_debt += contact_.ledger.debt_J > 0;
    sums_.above += jump > 0.05;
    sums_.jump_N = std::max(sums_.jump_N, jump);
    sums_.least_J = std::min(sums_.least_J, out_.stored_J + out_.dissipated_J);
    peak_J_ = std::max(peak_J_, out_.stored_J);
    const double lost = out_.dissipated_J - contact_.ledger.tank_J;
    const double rounding = 1e-15 * out_.dissipated_J;  // of the difference of the two
    const bool is_passive = lost >= lost_J_ - 1e-12 * peak_J_ - rounding;
    lost_J_ = lost;
    return is_passive;
  }

  const AssetView& asset_;
  Sums& sums_;
  Contact contact_;
  Output out_;
  Vec3d x_, force_{0, 0, 0};
  double lost_J_ = 0, peak_J_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const palpate::AssetFile file = palpate::read_asset_file(argv[1]);
  const AssetView& asset = file.asset();
  Random random{2 * std::strtoull(argv[3], nullptr, 10) + 1};
  std::vector<int> covered;
  for (int v = 0; v < asset.vertices; ++v)
    if (asset.covered[v] == kMeasured) covered.push_back(v);
  const double depth_m = asset.max_fitted_m;
  Sums sums;
  while (sums.ticks < std::atol(argv[2])) {
    const int v = covered[static_cast<std::size_t>(random.share() * double(covered.size()))];
    const Vec3d u = asset.normal_at(v), p = asset.vertex_at(v) + make_vec3<double>(asset.origin_m);
    Walk walk(asset, p - u * 0.003, sums);
    const double step_m = 2e-5 * std::pow(20, random.share());
    Vec3d to = p;
    bool is_passive = true;
    for (int leg = 0; leg < 6 && is_passive; ++leg) {
      const double a = random.share() - 0.5, b = random.share() - 0.5, c = random.share() - 0.5;
      const double down = depth_m * (0.2 + 0.75 * random.share());
      const bool lifts = random.share() < 0.15;
      to = p + tangential(Vec3d{a, b, c}, u) * (2 * depth_m) + u * (lifts ? -0.001 : down);
      is_passive = walk.go(to, step_m);
    }
    is_passive = is_passive && walk.go(to - u * (depth_m + 0.005), step_m);
    walk.end();
    if (is_passive) continue;
    std::printf("walk %ld of seed %s is not passive or was refused\n", sums.walks, argv[3]);
    return 1;
  }
  std::printf("%ld ticks in %ld walks, %ld in contact, %ld slipping\n", sums.ticks, sums.walks,
              sums.in_contact, sums.slipping);
  std::printf("work lost %.6g J, least work at any time %.3g J\n", sums.work_J, sums.least_J);
  std::printf("refused %.6g J, %ld ticks in debt\n", sums.refused_J, sums.in_debt);
  std::printf("largest change of the force %.4f N, %ld ticks above 0.05 N\n", sums.jump_N,
              sums.above);
  return sums.in_contact > sums.ticks / 4 && sums.least_J >= 0 ? 0 : 1;
}
