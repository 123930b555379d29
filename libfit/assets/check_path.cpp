#include "libfit/assets/check_path.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace palpate {
namespace {

constexpr int kPlaces = 12;             // 768 ticks: about 1 ms on loading
constexpr int kPress = 20, kDrag = 48;  // last tick of the press, of the drag

std::uint64_t next(std::uint64_t& state) {  // splitmix64 (Steele, Lea and Flood 2014)
  std::uint64_t z = (state += 0x9e3779b97f4a7c15U);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

double unit_share(std::uint64_t& state) { return static_cast<double>(next(state) >> 11) * 0x1p-53; }

Vec3 row(const std::vector<float>& array, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&array[3 * i]).cast<double>();
}

}  // namespace

std::vector<runtime::CheckTick> make_check_path(const AssetSurface& surface, double depth_m,
                                                std::uint64_t seed) {
  std::vector<runtime::CheckTick> path;
  for (int place = 0; place < kPlaces; ++place) {
    const auto& measured = surface.measured_triangles;
    const auto t = static_cast<std::size_t>(measured[next(seed) % measured.size()]);
    const double a = 0.2 + 0.3 * unit_share(seed), b = 0.2 + 0.3 * unit_share(seed);
    const double depth =
        std::min(depth_m, double(surface.max_depth_m[t])) * (0.3 + 0.7 * unit_share(seed));
    Vec3 x = Vec3::Zero(), u = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double n = k == 0 ? a : (k == 1 ? b : 1 - a - b);
      const auto v = static_cast<std::size_t>(surface.triangle[3 * t + k]);
      x += n * row(surface.vertex, v);
      u += n * row(surface.normal, v);
    }
    u.normalize();
    const Vec3 any(unit_share(seed) - 0.5, unit_share(seed) - 0.5, unit_share(seed) - 0.5);
    const Vec3 along = u.cross(any).normalized(), aside = u.cross(along);
    for (int tick = 0; tick < kCheckPathTicks; ++tick) {
      const double down = tick <= kPress ? double(tick) / kPress
                          : tick <= kDrag
                              ? 1.0
                              : 1 - double(tick - kDrag) / (kCheckPathTicks - 1 - kDrag);
      const double drag = double(std::clamp(tick - kPress, 0, kDrag - kPress)) / (kDrag - kPress);
      const Vec3 tip = surface.origin + x + u * depth * (1.25 * down - 0.25) +
                       depth * (3 * drag * along + drag * drag * aside);
      path.push_back({{tip[0], tip[1], tip[2]}, {0, 0, 0}});
    }
  }
  return path;
}

}  // namespace palpate
