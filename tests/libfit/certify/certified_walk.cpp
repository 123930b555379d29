// certified_walk ASSETS TICKS SEED: so many random ticks, the guard off, over so many random bodies
// that are certified. Exits with 1 where a tick creates energy beyond 1e-12 of the work done until
// then. A body that is not certified is drawn anew.

#include <cstdio>
#include <cstdlib>

#include "tests/libfit/certify/bodies.hpp"

namespace palpate::certify::test {
namespace {

constexpr double kStep_m = 5e-5;     // of the certificate's ticks
constexpr double kWithin_m = 0.015;  // of the middle; the interior ends 2 cm from it
constexpr double kAllowed = 1e-12;
constexpr long kControlTicks = 5000;  // without friction: it shall create energy

// A cap of a ball of 15 cm to 15 m, 6 cm wide, whose stiffness waves.
Model random_cap(unsigned seed, double friction_factor = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const double radius_m = 0.15 * std::pow(100, unit(random)), unevenness = 0.1 * unit(random),
               agreement = 0.5 + 0.5 * unit(random), friction = std::pow(10, -0.5 * unit(random));
  Model model = plate_model(0.06, 6, uniform(400, 300, 0.3));
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    Vec3 x = model.surface.vertices.row(v);
    x[2] = std::sqrt(radius_m * radius_m - x.head<2>().squaredNorm()) - radius_m;
    model.surface.vertices.row(v) = x.transpose();
    model.inward_normal.row(v) = -(x + Vec3(0, 0, radius_m)).normalized().transpose();
  }
  const auto wave = waves(seed);
  make_rings(
      model, friction_factor * friction, radius_m,
      [&](const Vec3& x) { return 1 + unevenness * wave(x); },
      [&](const Vec3& x) {
        Vec3 slope = Vec3::Zero();
        for (int k = 0; k < 2; ++k)
          slope[k] =
              unevenness * (wave(x + 1e-5 * Vec3::Unit(k)) - wave(x - 1e-5 * Vec3::Unit(k))) / 2e-5;
        return Vec3(agreement * 6 * slope);  // as in random_body()
      });
  return model;
}

bool is_certified(const runtime::AssetView& asset, double radius_m) {
  FacetOptions options;
  options.radius_m = radius_m;
  options.max_boxes = 200;
  for (int t = 0; t < asset.triangles; ++t)
    if (zone_of(asset, t) == Zone::interior &&
        (!pushes_on(asset, t, options) ||
         certify_sliding(asset, t, OtherRings::any, options).verdict != Verdict::certified))
      return false;
  return true;
}

struct Walked {
  long ticks = 0, slips = 0;
  double worst = 0;  // created at a tick, over the work until then
};

// Random legs, every fourth into the air.
Walked walk(const runtime::AssetView& asset, double radius_m, long ticks, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  Walked out;
  Contact contact;
  Vec3 x(0, 0, 0.001);
  double before_J = 0, stored_J = 0, moved_J = 0;
  for (int leg = 0; out.ticks < ticks; ++leg) {
    const double reach = leg % 3 == 0 ? 0.02 : 0.002;
    Vec3 to = x + reach * Vec3(draw(random), draw(random), 0);
    to = to.cwiseMax(-kWithin_m).cwiseMin(kWithin_m);
    to[2] = leg % 4 == 3 ? 0.0005 : -0.0095 * std::abs(draw(random));
    const Vec3 from = x;
    const int steps = static_cast<int>((to - from).norm() / kStep_m) + 1;
    for (int k = 1; k <= steps && out.ticks < ticks; ++k, ++out.ticks) {
      x = from + (to - from) * (double(k) / steps);
      const Vec3 ball = x + Vec3(0, 0, radius_m);
      Output tick;
      touch_ball(asset, contact, ball.data(), radius_m, tick);
      const double lost_J = tick.dissipated_J - before_J;
      moved_J += std::abs(tick.stored_J + lost_J - stored_J);
      if (moved_J > 0) out.worst = std::max(out.worst, -lost_J / moved_J);
      before_J = tick.dissipated_J;
      stored_J = tick.stored_J;
      out.slips += tick.state == ContactState::slip;
    }
  }
  return out;
}

int run(int assets, long ticks, unsigned seed) {
  Walked sum;
  unsigned drawn = 0;
  int creating = 0;  // of the same bodies with hardly any friction
  for (int found = 0; found < assets; ++drawn) {
    const unsigned body_seed = seed + drawn;
    const double radius_m = body_seed % 2 == 0 ? 0.004 : 0;
    const Loaded body = load(random_cap(body_seed));
    runtime::AssetView bare = body.asset;
    bare.has_guard = false;
    if (!is_certified(body.asset, radius_m)) continue;
    ++found;
    const Loaded slippery = load(random_cap(body_seed, 0.02));
    runtime::AssetView slippery_bare = slippery.asset;
    slippery_bare.has_guard = false;
    creating += walk(slippery_bare, radius_m, kControlTicks, body_seed).worst > kAllowed;
    const Walked one = walk(bare, radius_m, ticks / assets, body_seed);
    sum.ticks += one.ticks;
    sum.slips += one.slips;
    sum.worst = std::max(sum.worst, one.worst);
    if (one.worst > kAllowed)
      std::printf("seed %u: a tick creates %.3g of the work\n", body_seed, one.worst);
  }
  std::printf(
      "%d of %u bodies certified; %ld ticks, %ld slips; worst tick creates %.3g of the work. With "
      "a "
      "fiftieth of their friction %d create more than is allowed\n",
      assets, drawn, sum.ticks, sum.slips, sum.worst, creating);
  const bool is_weak = sum.slips * 10 < sum.ticks || creating * 2 < assets;
  return sum.worst > kAllowed || is_weak;
}

}  // namespace
}  // namespace palpate::certify::test

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  return palpate::certify::test::run(std::atoi(argv[1]), std::atol(argv[2]),
                                     static_cast<unsigned>(std::atoi(argv[3])));
}
