// (a) and (b): a point proxy on the surface, as haptic libraries ship it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/workshop/rivals/finger_proxy.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {
namespace {

struct PlacedPress {
  Vec3 position;
  validation::PressTable table;
};

// One of each test point.
std::vector<PlacedPress> placed_presses(const Samples& samples) {
  std::vector<PlacedPress> out;
  for (auto& [point, presses] : validation::presses_of(samples))
    out.push_back({samples.point_position.row(point), presses.front()});
  return out;
}

// The stiffness whose relative errors over all rows of the presses have the least sum.
double best_stiffness_N_m(const std::vector<PlacedPress>& presses, double floor_N) {
  const auto sum_of_errors = [&](double stiffness) {
    double sum = 0;
    for (const auto& [position, press] : presses)
      for (std::size_t i = 1; i < press.depth_m.size(); ++i)
        if (press.push_N[i] > floor_N)
          sum += std::abs(stiffness * press.depth_m[i] - press.push_N[i]) / press.push_N[i];
    return sum;
  };
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (const auto& [position, press] : presses)
    for (std::size_t i = 1; i < press.depth_m.size(); ++i) {
      const double stiffness = press.push_N[i] / press.depth_m[i];
      if (const double sum = sum_of_errors(stiffness); sum < least) least = sum, best = stiffness;
    }
  return best;
}

Vec3 vec3(const runtime::Vec3d& v) { return {v.x, v.y, v.z}; }

// A proxy of which a new one is made for each path.
struct Proxy {
  const runtime::AssetView& surface;
  double stiffness_N_m, friction;
  std::optional<FingerProxy> now = std::nullopt;
};

Rival proxy_rival(const RivalBody& body, const std::shared_ptr<Proxy>& proxy) {
  Rival rival;
  rival.bytes = surface_bytes(proxy->surface);
  rival.preparation_cpu_s = static_cast<double>(body.samples.points()) * body.pressed_cpu_s;
  rival.start = [proxy](const Vec3&) {
    proxy->now.emplace(proxy->surface, proxy->stiffness_N_m, proxy->friction);
  };
  return rival;
}

}  // namespace

double drag_ratio(const Samples& samples) {
  std::vector<double> ratio;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    const bool is_last =
        row + 1 == samples.rows() || samples.experiment[r + 1] != samples.experiment[r];
    if (samples.kind[r] != ExperimentKind::drag || samples.status[r] != RowStatus::good || !is_last)
      continue;
    const Vec3 force = samples.force.row(row), inward = samples.point_normal.row(samples.point[r]);
    const double along = force.dot(inward);
    ratio.push_back((force - along * inward).norm() / along);
  }
  return median(std::move(ratio));
}

std::size_t surface_bytes(const runtime::AssetView& asset) {
  return static_cast<std::size_t>(asset.vertices) * 3 * sizeof(float) +
         static_cast<std::size_t>(asset.triangles) * 6 * sizeof(std::int32_t);
}

std::vector<Rival> prepare_proxy(const RivalBody& body) {
  const double floor_N = relative_floor_N(body.samples);
  const double stiffness = best_stiffness_N_m(placed_presses(body.samples), floor_N);
  const auto proxy =
      std::make_shared<Proxy>(Proxy{body.asset.asset(), stiffness, drag_ratio(body.samples)});
  Rival rival = proxy_rival(body, proxy);
  rival.name = "proxy, one spring";
  rival.settings = fmt::format(
      "{:.0f} N/m, least sum of relative errors over the presses; cone {:.2f}, median of the drags",
      stiffness, proxy->friction);
  rival.force = [proxy](const Vec3& tip) { return vec3(proxy->now->tick(tip.data())); };
  return {rival};
}

std::vector<Rival> prepare_proxy_on_curves(const RivalBody& body) {
  const auto proxy =
      std::make_shared<Proxy>(Proxy{body.asset.asset(), 1, drag_ratio(body.samples)});
  const auto presses = std::make_shared<std::vector<PlacedPress>>(placed_presses(body.samples));
  Rival rival = proxy_rival(body, proxy);
  rival.name = "proxy, nearest curve";
  rival.settings = fmt::format("{} presses, straight between rows; cone {:.2f}", presses->size(),
                               proxy->friction);
  for (const PlacedPress& press : *presses)
    rival.bytes += (3 + 2 * press.table.depth_m.size()) * sizeof(double);
  rival.force = [proxy, presses](const Vec3& tip) -> Vec3 {
    const Vec3 delta = vec3(proxy->now->deflection(tip.data()));
    const double length_m = delta.norm();
    if (!(length_m > 0)) return Vec3::Zero();
    const Vec3 place = vec3(proxy->now->place());
    const PlacedPress& nearest = *std::ranges::min_element(
        *presses, {},
        [&](const PlacedPress& press) { return (press.position - place).squaredNorm(); });
    return nearest.table.at(length_m) / length_m * delta;
  };
  return {rival};
}

}  // namespace palpate::tools
