#include "libfem/probes/probes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace palpate::fem {
namespace {

constexpr double kSteepest_rad = 84 * std::numbers::pi / 180;
constexpr double kRound = 1e-6;  // of a slope: how alike it is all around
constexpr int kPlaces = 1200;    // along a profile, before most are left out

struct ProfilePlace {
  double r_m, angle_rad;  // of the surface, 0 where it is flat
};

// The surface's slope at r from the axis, `around` it; nothing where there is none below.
std::optional<double> angle_at(const Probe& probe, double r_m, double around_rad) {
  const Vec3 axis = Vec3::UnitZ(), out(std::cos(around_rad), std::sin(around_rad), 0);
  double height_m = 0;  // above the reference point
  for (int step = 0; step < 100; ++step) {
    const SignedDistance at = probe.distance(axis, r_m * out - height_m * axis);
    const double along = at.gradient.dot(axis);
    if (!(along > std::cos(kSteepest_rad) / 2)) return std::nullopt;
    const double step_m = at.distance_m / along;  // distance falls as the place rises into the tool
    if (std::abs(at.distance_m) <= 1e-13 * probe.length_m)
      return std::atan2(at.gradient.dot(out), along);
    height_m += step_m;
  }
  return std::nullopt;
}

std::vector<ProfilePlace> profile_of(const Probe& probe) {
  // Shapes that widen without end are followed to 60 radii of the tip.
  const double tip_m = probe.shape->tip_radius_m(probe.geometry),
               width_m = std::min(probe.shape->half_width_m(probe.geometry), 60.0 * tip_m);
  std::vector<ProfilePlace> places{{0, 0}};
  for (int i = 1; i < kPlaces; ++i) {
    // Half of them where tips are, half over the whole width.
    const double share = double(i) / kPlaces;
    const double r_m = width_m * (width_m > 2 * tip_m ? share * share : share);
    const auto angle = angle_at(probe, r_m, 0.3);
    if (!angle || *angle > kSteepest_rad) break;
    for (const double around : {1.7, 3.9, 5.2}) {
      const auto other = angle_at(probe, r_m, around);
      if (!other || std::abs(*other - *angle) > kRound) return {};
    }
    if (*angle < places.back().angle_rad - kRound) return {};
    places.push_back({r_m, std::max(*angle, places.back().angle_rad)});
  }
  return places;
}

// Leaves out places between which slopes are linear to a tolerance (Ramer, Douglas, Peucker).
void keep_turns(const std::vector<ProfilePlace>& places, std::size_t from, std::size_t to,
                double tolerance, std::vector<char>& is_kept) {
  double most = 0;
  std::size_t at = from;
  for (std::size_t i = from + 1; i < to; ++i) {
    const double share = (places[i].r_m - places[from].r_m) / (places[to].r_m - places[from].r_m);
    const double line =
        (1 - share) * std::tan(places[from].angle_rad) + share * std::tan(places[to].angle_rad);
    // Slopes below 0.03 need be right to no share of themselves.
    const double residual =
        std::abs(std::atan(line) - places[i].angle_rad) / (0.03 + places[i].angle_rad);
    if (residual > most) most = residual, at = i;
  }
  if (!(most > tolerance)) return;
  is_kept[at] = 1;
  keep_turns(places, from, at, tolerance, is_kept);
  keep_turns(places, at, to, tolerance, is_kept);
}

}  // namespace

std::optional<Indenter> round_end(const Probe& probe) {
  Indenter out;
  if (probe.shape->name == std::string_view("sphere")) {
    out.round_end_m = probe.shape->tip_radius_m(probe.geometry);
    return out;
  }
  if (probe.leans) return std::nullopt;
  const std::vector<ProfilePlace> places = profile_of(probe);
  if (places.size() < 8) return std::nullopt;
  std::vector<char> is_kept;
  for (double tolerance = 3e-4;; tolerance *= 1.5) {
    is_kept.assign(places.size(), 0);
    is_kept.front() = is_kept.back() = 1;
    keep_turns(places, 0, places.size() - 1, tolerance, is_kept);
    if (std::ranges::count(is_kept, 1) <= runtime::kMaxProfilePoints) break;
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_kept[i]) continue;
    out.r_m[out.points] = places[i].r_m;
    out.slope[out.points++] = std::tan(places[i].angle_rad);
  }
  const double first = std::tan(places[1].angle_rad);
  out.round_end_m = first > kRound ? places[1].r_m / std::sin(places[1].angle_rad) : 0;
  return out;
}

std::optional<Indenter> round_end(const std::optional<ProbeSpec>& probe) {
  if (!probe || probe->shape == "point") return std::nullopt;
  return round_end(make_probe(*probe, "the probe of the data"));
}

}  // namespace palpate::fem
