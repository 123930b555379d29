#include "libfit/certify/cap.hpp"

#include <algorithm>
#include <limits>

namespace palpate::certify {
namespace {

constexpr double kSoftest_N_m = 10;  // what every device shows
constexpr double kWithin = 1.01;     // of the stiffness that is sought

}  // namespace

double stiffness_shown_N_m(const Device& device, double force_N) {
  const double most = device.max_stiffness_N_m > 0 ? device.max_stiffness_N_m
                                                   : std::numeric_limits<double>::infinity();
  if (!(device.mass_kg > 0)) return most;
  double shown = kSoftest_N_m, swings = std::min(most, 1e5);
  if (swinging_hands(device, swings, force_N) == 0) return most;
  while (swings > kWithin * shown) {
    const double middle = std::sqrt(shown * swings);
    (swinging_hands(device, middle, force_N) == 0 ? shown : swings) = middle;
  }
  return shown;
}

// (M29c)
AssetEdit capped(const runtime::AssetView& asset, double stiffness_N_m) {
  AssetEdit out(asset);
  const runtime::SplineView& curve = asset.curves.view[runtime::kNormal];
  const int degree = curve.degree, controls = curve.pieces + degree;
  const auto knot = [&](int i) { return curve.knots[std::clamp(i, 0, curve.pieces)]; };
  for (int v = 0; v < asset.vertices; ++v) {
    if (!asset.covered[v]) continue;
    float* b = out.node(v) + asset.control_offset[runtime::kNormal];
    float before = 0;
    for (int j = 0; j < controls; ++j) {
      const double span_m = j > 0 ? (knot(j) - knot(j - degree)) / degree : 0;
      const double rise = std::min(double(b[j]) - before, stiffness_N_m * span_m);
      before = b[j];
      b[j] = static_cast<float>((j > 0 ? double(b[j - 1]) : 0) + rise);
    }
  }
  out.seal();
  return out;
}

}  // namespace palpate::certify
